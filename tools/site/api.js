// The API reference has the site's colours: those of the site's toggle, or the system's until it is used.
const site = new URL("..", document.currentScript.src).pathname;
const palette = JSON.parse(localStorage.getItem(`${site}.__palette`) ?? "null");
if (palette) {
  document.documentElement.classList.add(palette.color.scheme === "slate" ? "dark-mode" : "light-mode");
}

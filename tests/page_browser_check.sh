#!/bin/sh
# page_browser_check.sh PAGE [FOLDER [PROBE]]: opens a report page in headless Chromium as a desktop
# and as a phone would, lets tests/page_probe.js (or PROBE) use it, and fails on an error in the console, a failed check
# or an empty picture. The pictures stay in FOLDER when one is given. Exit 77: no Chromium.
set -u
page=$(readlink -f "$1")
here=$(dirname "$(readlink -f "$0")")
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || exit 77
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
out=${2:-$work}
mkdir -p "$out"

# browse NAME FILE OPTION...
browse() {
  name=$1; file=$2; shift 2
  exec timeout 60 "$browser" --headless --no-sandbox --disable-gpu --disable-quic --no-first-run \
    --disable-background-networking --disable-component-update --disable-sync --hide-scrollbars \
    --user-data-dir="$work/profile-$name" --enable-logging=stderr "$@" "file://$file" \
    >"$work/$name.log" 2>&1
}

# look NAME FILE WIDTH HEIGHT: a picture, and a console without a word.
look() {
  (browse "$1" "$2" --virtual-time-budget=4000 --window-size="$3,$4" --screenshot="$out/$1.png")
  grep -o 'CONSOLE.*' "$work/$1.log" && return 1
  size=$(stat -c %s "$out/$1.png" 2>/dev/null || echo 0)
  # A page of one colour is a PNG of a few kilobytes.
  [ "$size" -gt 40000 ] || { echo "$1: the picture is empty ($size bytes)"; return 1; }
}

# use NAME FILE WIDTH HEIGHT: lets the probe use the page, in real time, until it says that it is done.
use() {
  (browse "$1" "$2" --remote-debugging-port=0 --window-size="$3,$4") &
  pid=$!
  tries=0
  until grep -q 'PROBE ok: done' "$work/$1.log" 2>/dev/null || [ $tries -ge 250 ]; do
    kill -0 $pid 2>/dev/null || break
    sleep 0.2
    tries=$((tries + 1))
  done
  kill $pid 2>/dev/null
  wait $pid 2>/dev/null
  grep -o 'CONSOLE.*' "$work/$1.log" | grep -v 'PROBE ok' && { echo "$1: see the console"; return 1; }
  grep -q 'PROBE ok: done' "$work/$1.log" || { echo "$1: the probe did not finish"; return 1; }
}

{ cat "$page"; printf '<script>\n'; cat "$here/${3:-page_probe.js}"; printf '</script>\n'; } >"$work/probed.html"
# Chromium's window is never as narrow as a phone: a frame in it is.
cat >"$work/phone.html" <<HTML
<!DOCTYPE html><body style="margin:0"><iframe src="probed.html" style="width:390px;height:4000px;border:0">
</iframe>
HTML
sed 's/probed.html/page.html/' "$work/phone.html" >"$work/phone-look.html"
cp "$page" "$work/page.html"

status=0
look desktop "$page" 1400 2200 || status=1
look phone "$work/phone-look.html" 500 4000 || status=1
use desktop-use "$work/probed.html" 1400 2200 || status=1
use phone-use "$work/phone.html" 500 4000 || status=1
exit $status

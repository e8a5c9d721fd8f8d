// How checks are reported.
const failures = [];

export function check(name, passed, detail = '') {
  if (!passed) failures.push(`${name}${detail ? `: ${detail}` : ''}`);
}

/** Says what failed, at most so much; the exit status of the test. */
export function verdict() {
  for (const failure of failures.slice(0, 40)) console.error(`FAILED: ${failure}`);
  return failures.length ? 1 : 0;
}

// @ts-check
/** Numbers as people read them: thousands with commas, never with an exponent, and the right word after them. Pure. */

/** A smaller number than this is not told apart from others in three digits. */
const SMALL = 1e-4;

/** @param {number|null|undefined} value @returns {string} `132,400` */
export function count(value) {
  return value === null || value === undefined ? '–' : value.toLocaleString('en-GB');
}

/** @param {number} value @param {string} one @param {string} [many] @returns {string} `1 run`, `3 runs` */
export function plural(value, one, many = `${one}s`) {
  return `${count(value)} ${value === 1 ? one : many}`;
}

/**
 * @param {number|null|undefined} value
 * @param {number} [digits]   significant digits; up to three, what is very small is only said to be so
 * @returns {string} `4.19`, `1,230`, `<0.0001`
 */
export function figure(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  if (Number.isInteger(value)) return count(value + 0); // + 0: never -0
  if (digits <= 3 && Math.abs(value) < SMALL) return value > 0 ? `<${SMALL.toFixed(4)}` : `>-${SMALL.toFixed(4)}`;
  return value.toLocaleString('en-GB', { maximumSignificantDigits: digits });
}

// @ts-check
/** Perceptual hashes as bits. Pure. */

/**
 * @param {string} hex   16 hexadecimal digits
 * @returns {Uint8Array} 64 bits, row by row, the highest first
 * @throws {RangeError} not 16 hexadecimal digits
 */
export function hashBits(hex) {
  if (!/^[0-9a-f]{16}$/i.test(hex)) throw new RangeError(`A hash has 16 hexadecimal digits, got '${hex}'.`);
  const bits = new Uint8Array(64);
  for (let i = 0; i < 64; i += 1) bits[i] = (Number.parseInt(hex[i >> 2], 16) >> (3 - (i & 3))) & 1;
  return bits;
}

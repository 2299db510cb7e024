// @ts-check
/**
 * Preset and parameters of the last started run; the next run starts with them. Pure.
 *
 * @typedef {import('../types.js').Parameter} Parameter
 * @typedef {{preset: string, parameters: Record<string, unknown>}} RunChoice
 */

/** @param {RunChoice} choice @returns {string} the form in which it is remembered */
export const formatRunChoice = ({ preset, parameters }) => JSON.stringify({ preset, parameters });

/**
 * The remembered choice, checked field by field, because it may come from another version.
 *
 * @param {string|null} text
 * @param {readonly string[]} presets
 * @param {readonly Parameter[]} parameters   the parameters that exist
 * @returns {RunChoice}
 */
export function parseRunChoice(text, presets, parameters) {
  /** @type {RunChoice} */
  const defaults = { preset: presets.includes('default') ? 'default' : (presets[0] ?? 'default'), parameters: {} };
  const stored = parseJson(text);
  if (stored === null || typeof stored !== 'object' || !presets.includes(Reflect.get(stored, 'preset'))) return defaults;
  const values = Reflect.get(stored, 'parameters');
  const known = new Set(parameters.map(({ name }) => name));
  const pairs = values !== null && typeof values === 'object' ? Object.entries(values).filter(([name]) => known.has(name)) : [];
  return { preset: Reflect.get(stored, 'preset'), parameters: Object.fromEntries(pairs) };
}

/** @param {string|null} text @returns {unknown} */
function parseJson(text) {
  try {
    return JSON.parse(text ?? 'null');
  } catch {
    return null;
  }
}

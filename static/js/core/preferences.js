// @ts-check
/**
 * Preferences that this browser remembers: sizes, sort orders, theme. If its storage is disabled or full, nothing is
 * remembered.
 */

import { LAYERS, DEFAULT_LAYERS } from '../store/initial.js';

/** @param {string} name @returns {string|null} */
export function recall(name) {
  try {
    return localStorage.getItem(`tsr.${name}`);
  } catch {
    return null;
  }
}

/** @param {string} name @param {string|number} value */
export function remember(name, value) {
  try {
    localStorage.setItem(`tsr.${name}`, String(value));
  } catch {
    // As above.
  }
}

/**
 * The author of changes from this page: the person who is signed in, else the name that this browser remembers.
 *
 * @param {import('../types.js').Session|null} session
 * @returns {string|null} null: the server's default
 */
export const authorName = (session) => session?.person?.name ?? recall('author');

/** @typedef {Record<import('../state-types.js').LayerName, boolean>} Layers */

/** @returns {Layers} */
export function rememberedLayers() {
  const value = recall('layers');
  if (value === null) return DEFAULT_LAYERS;
  const shown = new Set(value.split(' '));
  return /** @type {Layers} */ (Object.fromEntries(LAYERS.map((name) => [name, shown.has(name)])));
}

/** @returns {boolean} */
export const rememberedFewLabels = () => recall('labels') === 'few';

/** @returns {import('../state-types.js').State['lanesView']} */
export const rememberedLanesView = () => ({ folded: recall('lanes') !== 'all', lane: recall('lane') ?? 'gate' });

/** @returns {'light'|'dark'|'auto'} */
export function rememberedTheme() {
  const value = recall('theme');
  return value === 'light' || value === 'dark' ? value : 'auto';
}

/**
 * Remember theme, layers, labels and lanes as soon as they are chosen: a reload may come before the next drawing.
 *
 * @param {import('../state-types.js').Store} store
 */
export function rememberChoices(store) {
  let { theme, layers, fewLabels, lanesView } = store.get();
  store.subscribe((state) => {
    if (state.theme !== theme) remember('theme', state.theme);
    if (state.layers !== layers) remember('layers', LAYERS.filter((name) => state.layers[name]).join(' '));
    if (state.fewLabels !== fewLabels) remember('labels', state.fewLabels ? 'few' : 'all');
    if (state.lanesView !== lanesView) {
      remember('lanes', state.lanesView.folded ? 'folded' : 'all');
      remember('lane', state.lanesView.lane);
    }
    ({ theme, layers, fewLabels, lanesView } = state);
  });
}

/** @param {string} name */
export function forget(name) {
  try {
    localStorage.removeItem(`tsr.${name}`);
  } catch {
    // As above.
  }
}

/** Maximum number of hidden notices that are remembered. */
const MAX_DISMISSED = 100;

/** @returns {string[]} oldest first */
const dismissedNames = () => (recall('put-away') ?? '').split(' ').filter(Boolean);

/** Whether the user has hidden a notice before. @param {string} name */
export const isDismissed = (name) => dismissedNames().includes(name);

/** Remember that a notice is hidden, and forget the oldest ones. @param {string} name   without spaces */
export function dismiss(name) {
  remember('put-away', [...dismissedNames().filter((known) => known !== name), name].slice(-MAX_DISMISSED).join(' '));
}

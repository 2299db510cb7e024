// @ts-check
/** Several videos that are added or run at once: which ones, and what has come of them. Pure. */

import { plural } from './format.js';

/** @typedef {import('../types.js').Video} Video */

/**
 * @param {readonly string[]} chosen   paths, in the order in which they were chosen
 * @param {string} path
 * @returns {readonly string[]}
 */
export const toggled = (chosen, path) => (chosen.includes(path) ? chosen.filter((other) => other !== path) : [...chosen, path]);

/**
 * Do something to one after the other; one that fails keeps no other back.
 *
 * @template T, R
 * @param {readonly T[]} things
 * @param {(thing: T) => Promise<R>} act
 * @param {(thrown: unknown) => string} words
 * @returns {Promise<{done: R[], left: T[], errors: string[]}>} `left`: those that failed, each with its error
 */
export async function oneByOne(things, act, words) {
  /** @type {{done: R[], left: T[], errors: string[]}} */
  const found = { done: [], left: [], errors: [] };
  for (const thing of things) {
    try {
      found.done.push(await act(thing));
    } catch (thrown) {
      found.left.push(thing);
      found.errors.push(words(thrown));
    }
  }
  return found;
}

/** Those that the engine could run on and has not. @param {readonly Video[]} videos @returns {Video[]} */
export const notRunYet = (videos) => videos.filter(({ state, missing, runs }) => state === 'ready' && !missing && runs === 0);

/** What is said of those that were added. @param {readonly Video[]} added @returns {string} */
export function addedWords(added) {
  const coming = added.filter(({ state }) => state === 'importing').length;
  if (added.length === 1) return `${added[0].name} is ${coming ? 'being imported' : 'in the library'}.`;
  if (coming === 0) return `${plural(added.length, 'video')} are in the library.`;
  return coming === added.length
    ? `${coming} videos are being imported.`
    : `${coming} of ${added.length} videos are being imported, the others are in the library.`;
}

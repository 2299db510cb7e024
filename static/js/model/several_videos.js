// @ts-check
/** Adding or running several videos at once: the choice and the outcome. Pure. */

import { plural } from './format.js';

/** @typedef {import('../types.js').Video} Video */

/**
 * @param {readonly string[]} chosen   paths, in the order of choice
 * @param {string} path
 * @returns {readonly string[]}
 */
export const togglePath = (chosen, path) => (chosen.includes(path) ? chosen.filter((other) => other !== path) : [...chosen, path]);

/**
 * Process things one after the other; a failure does not stop the rest.
 *
 * @template T, R
 * @param {readonly T[]} items
 * @param {(thing: T) => Promise<R>} act
 * @param {(thrown: unknown) => string} describeError
 * @returns {Promise<{done: R[], left: T[], errors: string[]}>} `left`: the failed ones; `errors`: one for each of them
 */
export async function processAll(items, act, describeError) {
  /** @type {{done: R[], left: T[], errors: string[]}} */
  const found = { done: [], left: [], errors: [] };
  for (const item of items) {
    try {
      found.done.push(await act(item));
    } catch (thrown) {
      found.left.push(item);
      found.errors.push(describeError(thrown));
    }
  }
  return found;
}

/** The videos on which the engine can run and has not run. @param {readonly Video[]} videos @returns {Video[]} */
export const videosWithoutRun = (videos) => videos.filter(({ state, missing, runs }) => state === 'ready' && !missing && runs === 0);

/** The message about added videos. @param {readonly Video[]} added @returns {string} */
export function addedMessage(added) {
  const importing = added.filter(({ state }) => state === 'importing').length;
  if (added.length === 1) return `${added[0].name} is ${importing ? 'being imported' : 'in the library'}.`;
  if (importing === 0) return `${plural(added.length, 'video')} are in the library.`;
  return importing === added.length
    ? `${importing} videos are being imported.`
    : `${importing} of ${added.length} videos are being imported, the rest are in the library.`;
}

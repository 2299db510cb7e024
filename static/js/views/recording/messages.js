// @ts-check
/** Messages between the page and the viewer's frame by `postMessage`, within one origin. */

/**
 * @typedef {{type: 'start', version: string, theme: 'light'|'dark', url: string}
 *   | {type: 'seek', frame: number}
 *   | {type: 'select', entity: string}} ToFrame
 */

/**
 * @typedef {{type: 'ready'}
 *   | {type: 'opened', application: string, recording: string}
 *   | {type: 'time', frame: number}
 *   | {type: 'selected', entity: string|null, instance: number|null}
 *   | {type: 'refused', what: string, message: string}
 *   | {type: 'failed', reason: string, message: string}} FromFrame
 */

/**
 * Check a message: other scripts can send messages to the window too.
 *
 * @param {unknown} data
 * @param {readonly string[]} types
 * @returns {ToFrame|FromFrame|null}
 */
export function readMessage(data, types) {
  if (typeof data !== 'object' || data === null || !('type' in data)) return null;
  return types.includes(/** @type {string} */ (data.type)) ? /** @type {ToFrame|FromFrame} */ (data) : null;
}

// @ts-check
/** Tells how a file turned out that somebody asked for on this page, wherever they are by then. */

import {isActive} from './artefact-words.js';
import {toast} from './toasts.js';

/** @typedef {import('../types.js').Artefact} Artefact */
/** @typedef {import('./toasts.js').ToastOptions & {text: string}} Notice */

/**
 * What is to be said of a file; null: nothing, as it is in sight.
 *
 * @param {Artefact|undefined} artefact   unset: somebody has deleted it
 * @param {boolean} inSight               the list of files is on the screen
 * @returns {{text: string, tone: 'good'|'bad', offers: 'download'|'files'}|null}
 */
export function madeWords(artefact, inSight) {
  if (!artefact || inSight || artefact.state === 'cancelled') return null;
  if (artefact.state === 'complete') return {text: `${artefact.name} is ready.`, tone: 'good', offers: 'download'};
  return {text: `${artefact.name} could not be made: ${artefact.error ?? 'the terminal of the server says why.'}`, tone: 'bad', offers: 'files'};
}

/**
 * Wait for a file and tell, once.
 *
 * @param {Pick<import('../page-types.js').App, 'store' | 'signal' | 'api'>} app
 * @param {string} id     of the file; it is in the store, or the list of files is still being loaded
 * @param {(notice: Notice) => void} [say]
 */
export function tellWhenMade(app, id, say = ({text, ...options}) => toast(text, options)) {
  const stop = app.store.subscribe(({artefacts, route}) => {
    const artefact = artefacts?.find((one) => one.id === id);
    if (artefacts === null || (artefact && isActive(artefact))) return;
    stop();
    const words = madeWords(artefact, route.screen === 'files');
    if (!words) return;
    const action = words.offers === 'download'
      ? {label: 'Download', run: () => location.assign(app.api.downloadUrl(id))}
      : {label: 'Files', run: () => location.assign('#/files')};
    say({text: words.text, tone: words.tone, action, topic: `made-${id}`, stays: true});
  });
  app.signal.addEventListener('abort', stop, {once: true});
}

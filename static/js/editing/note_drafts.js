// @ts-check
/**
 * Notes that are half written, each with the track of the run that it is about. They outlive another selection, a closed
 * dialog and a reload; storage that is switched off or full costs the reload only.
 *
 * @typedef {object} NoteDrafts
 * @property {(run: string, key: string) => string} of        empty: none
 * @property {(run: string, key: string, text: string) => void} keep   an empty text forgets it
 * @property {(listener: () => void, signal: AbortSignal) => void} onKept      called after each, until the signal ends it
 */

/**
 * @param {() => Pick<Storage, 'getItem'|'setItem'|'removeItem'>} storage   asked anew each time: a browser may refuse it
 * @returns {NoteDrafts}
 */
export function createNoteDrafts(storage) {
  /** What is written on this page, also where nothing can be stored. @type {Map<string, string>} */
  const known = new Map();
  /** @type {Set<() => void>} */
  const listeners = new Set();
  /** @param {string} run @param {string} key */
  const nameOf = (run, key) => `tsr.note.${run}.${key}`;
  return {
    of(run, key) {
      const name = nameOf(run, key);
      const here = known.get(name);
      if (here !== undefined) return here;
      let kept = '';
      try {
        kept = storage().getItem(name) ?? '';
      } catch {
        // Nothing was kept.
      }
      known.set(name, kept);
      return kept;
    },
    keep(run, key, text) {
      const name = nameOf(run, key);
      const kept = text.trim() === '' ? '' : text;
      known.set(name, kept);
      try {
        if (kept === '') storage().removeItem(name);
        else storage().setItem(name, kept);
      } catch {
        // As above.
      }
      for (const listener of listeners) listener();
    },
    onKept(listener, signal) {
      listeners.add(listener);
      signal.addEventListener('abort', () => listeners.delete(listener));
    },
  };
}

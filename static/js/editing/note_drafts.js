// @ts-check
/**
 * Drafts of notes, each for a track of a run. They survive another selection, a closed dialog and a reload. If storage
 * is disabled or full, they do not survive a reload.
 *
 * @typedef {object} NoteDrafts
 * @property {(run: string, key: string) => string} of        the draft; empty: none
 * @property {(run: string, key: string, text: string) => void} keep   an empty text removes the draft
 * @property {(listener: () => void, signal: AbortSignal) => void} onKept      called after each `keep`, until the signal is aborted
 */

/**
 * @param {() => Pick<Storage, 'getItem'|'setItem'|'removeItem'>} storage   called for each access, because a browser may refuse storage
 * @returns {NoteDrafts}
 */
export function createNoteDrafts(storage) {
  /** The drafts of this page, also if they cannot be stored. @type {Map<string, string>} */
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
        // Storage is disabled: there are no earlier drafts.
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
        // Storage is disabled or full: the draft stays in `known`.
      }
      for (const listener of listeners) listener();
    },
    onKept(listener, signal) {
      listeners.add(listener);
      signal.addEventListener('abort', () => listeners.delete(listener));
    },
  };
}

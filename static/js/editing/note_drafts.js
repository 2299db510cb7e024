// @ts-check
/**
 * Drafts of notes, each for a track of a run. They survive another selection, a closed dialog and a reload. If storage
 * is disabled or full, they do not survive a reload.
 *
 * @typedef {object} NoteDrafts
 * @property {(run: string, key: string) => string} get        the draft; empty: none
 * @property {(run: string, key: string, text: string) => void} set   an empty text removes the draft
 * @property {(listener: () => void, signal: AbortSignal) => void} onChange      called after each `set`, until the signal is aborted
 */

/**
 * @param {() => Pick<Storage, 'getItem'|'setItem'|'removeItem'>} storage   called for each access, because a browser may refuse storage
 * @returns {NoteDrafts}
 */
export function createNoteDrafts(storage) {
  /** The drafts of this page, also if they cannot be stored. @type {Map<string, string>} */
  const drafts = new Map();
  /** @type {Set<() => void>} */
  const listeners = new Set();
  /** @param {string} run @param {string} key */
  const storageKey = (run, key) => `tsr.note.${run}.${key}`;
  return {
    get(run, key) {
      const name = storageKey(run, key);
      const draft = drafts.get(name);
      if (draft !== undefined) return draft;
      let stored = '';
      try {
        stored = storage().getItem(name) ?? '';
      } catch {
        // Storage is disabled: there are no earlier drafts.
      }
      drafts.set(name, stored);
      return stored;
    },
    set(run, key, text) {
      const name = storageKey(run, key);
      const draft = text.trim() === '' ? '' : text;
      drafts.set(name, draft);
      try {
        if (draft === '') storage().removeItem(name);
        else storage().setItem(name, draft);
      } catch {
        // Storage is disabled or full: the draft stays in `drafts`.
      }
      for (const listener of listeners) listener();
    },
    onChange(listener, signal) {
      listeners.add(listener);
      signal.addEventListener('abort', () => listeners.delete(listener));
    },
  };
}

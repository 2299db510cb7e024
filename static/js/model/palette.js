// @ts-check
/**
 * What the palette finds: every typed word must be in an item, from its start, inside, or letter by letter. Pure.
 *
 * @typedef {object} Findable
 * @property {string} text    what people read
 * @property {string} [also]  further words that find it
 */

/** What may stand for several words; a number stands for itself. */
const LETTERS = /^\p{L}{2,}$/u;
/** Between the words of an item. */
const BETWEEN = /[^\p{L}\p{N}#]+/u;

/**
 * Lower-case words of items, so that a keystroke does not make them anew.
 * @template {Findable} T
 * @param {readonly T[]} items
 */
export const prepared = (items) =>
  items.map((item) => {
    const text = item.text.toLowerCase();
    return { item, text, words: wordsOf(text), also: wordsOf((item.also ?? '').toLowerCase()) };
  });

/** @param {string} text */
const wordsOf = (text) => text.split(BETWEEN).filter(Boolean);

/**
 * @template {Findable} T
 * @param {ReturnType<typeof prepared<T>>} items
 * @param {string} typed
 * @param {number} most
 * @returns {{found: T[], total: number}} the best first, equal ones in their order; `total` counts those beyond `most` too
 */
export function findItems(items, typed, most) {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  const ranked = items.flatMap((one, place) => {
    const { item } = one;
    let rank = 0;
    for (const word of words) {
      const fit = rankOf(word, one);
      if (fit === 0) return [];
      rank += fit;
    }
    return [{ item, place, rank }];
  });
  ranked.sort((a, b) => b.rank - a.rank || a.place - b.place);
  return { found: ranked.slice(0, most).map(({ item }) => item), total: ranked.length };
}

/**
 * How well a word fits: best a word of the text, then the start of one, the inside, a word beside the text or the start of one,
 * and at last its letters in order. 0: not at all.
 * @param {string} word
 * @param {{text: string, words: readonly string[], also: readonly string[]}} item
 */
function rankOf(word, { text, words, also }) {
  if (words.includes(word)) return 6;
  if (words.some((one) => one.startsWith(word))) return 5;
  if (text.includes(word)) return 4;
  if (also.includes(word)) return 3;
  if (also.some((one) => one.startsWith(word))) return 2;
  return LETTERS.test(word) && words.some((_, first) => inOrder(word, words, first)) ? 1 : 0;
}

/**
 * Whether the letters of a word stand in order in the words from one on, and that one begins with the first of them: `dtr` is
 * "delete track".
 * @param {string} word @param {readonly string[]} own @param {number} first
 */
function inOrder(word, own, first) {
  if (own[first][0] !== word[0]) return false;
  let at = 0;
  for (let i = first; i < own.length && at < word.length; i += 1) {
    for (const letter of own[i]) if (letter === word[at]) at += 1;
  }
  return at === word.length;
}

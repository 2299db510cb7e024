// @ts-check
/**
 * Search of the command palette: an item must match every typed word: at its start, inside, or letter by letter. Pure.
 *
 * @typedef {object} Findable
 * @property {string} text    the text on the screen
 * @property {string} [also]  further words to search in
 */

/** Words that may abbreviate several words; a number may not. */
const ABBREVIATION = /^\p{L}{2,}$/u;
/** Separators between the words of an item. */
const SEPARATORS = /[^\p{L}\p{N}#]+/u;

/**
 * Items with their words in lower case, computed once for all keystrokes.
 * @template {Findable} T
 * @param {readonly T[]} items
 */
export const prepareItems = (items) =>
  items.map((item) => {
    const text = item.text.toLowerCase();
    return { item, text, words: wordsOf(text), also: wordsOf((item.also ?? '').toLowerCase()) };
  });

/** @param {string} text */
const wordsOf = (text) => text.split(SEPARATORS).filter(Boolean);

/**
 * @template {Findable} T
 * @param {ReturnType<typeof prepareItems<T>>} items
 * @param {string} typed
 * @param {number} maxCount
 * @returns {{found: T[], total: number}} best first, ties in their order; `total` also counts those beyond `most`
 */
export function findItems(items, typed, maxCount) {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  const ranked = items.flatMap((one, position) => {
    const { item } = one;
    let rank = 0;
    for (const word of words) {
      const fit = rankOf(word, one);
      if (fit === 0) return [];
      rank += fit;
    }
    return [{ item, place: position, rank }];
  });
  ranked.sort((a, b) => b.rank - a.rank || a.place - b.place);
  return { found: ranked.slice(0, maxCount).map(({ item }) => item), total: ranked.length };
}

/**
 * How well a word fits. Best is a word of the text, then the start of one, the inside of one, a further word or its
 * start, and last its letters in order. 0: no match.
 * @param {string} word
 * @param {{text: string, words: readonly string[], also: readonly string[]}} item
 */
function rankOf(word, { text, words, also }) {
  if (words.includes(word)) return 6;
  if (words.some((one) => one.startsWith(word))) return 5;
  if (text.includes(word)) return 4;
  if (also.includes(word)) return 3;
  if (also.some((one) => one.startsWith(word))) return 2;
  return ABBREVIATION.test(word) && words.some((_, first) => hasLettersInOrder(word, words, first)) ? 1 : 0;
}

/**
 * Whether the letters of a word occur in order in the words from `first` on, and that word begins with the first
 * letter: `dtr` matches "delete track".
 * @param {string} word @param {readonly string[]} itemWords @param {number} first
 */
function hasLettersInOrder(word, itemWords, first) {
  if (itemWords[first][0] !== word[0]) return false;
  let at = 0;
  for (let i = first; i < itemWords.length && at < word.length; i += 1) {
    for (const letter of itemWords[i]) if (letter === word[at]) at += 1;
  }
  return at === word.length;
}

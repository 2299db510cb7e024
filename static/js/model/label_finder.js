// @ts-check
/**
 * Finds the label that a word names, and the labels that a search finds. `comparable` and `find` are twins of
 * tsr_engine/labels/name_matching.py and matching.py: tests/labels/words.json holds the answers that both give. Pure.
 *
 * @typedef {import('../types.js').Label} Label
 * @typedef {'key'|'name'|'alias'|'short'|'number'} MatchedPart   the part of a label that matched
 */
import { labelsById } from './labels.js';

/** Python's `\s`, and the punctuation in names. */
const IGNORED_CHARACTERS = /[\t-\r\x1c-\x20\x85\xa0\u1680\u2000-\u200a\u2028\u2029\u202f\u205f\u3000_\-./,:;()'"]+/gu;
const BETWEEN_NUMBERS = new RegExp(`(?<=\\p{Nd})${IGNORED_CHARACTERS.source}(?=\\p{Nd})`, 'gu');
const NUMBER = /^(?:#|(?:class|label|id|c)[\s_:#-]*)?0*(\d{1,9})$/i;

/** Letters whose case folding differs from that of their capital. @type {Record<string, string>} */
const SPECIAL_FOLDINGS = { ı: 'ı', ẞ: 'ss' };
const CHEROKEE = /[\u13a0-\u13fd\uab70-\uabbf]/;

/** @param {string} letter */
function foldCase(letter) {
  const special = SPECIAL_FOLDINGS[letter];
  if (special !== undefined) return special;
  return CHEROKEE.test(letter) ? letter.toUpperCase() : [...letter.toUpperCase()].map((part) => part.toLowerCase()).join('');
}

/**
 * A name without case, spaces and punctuation, in Unicode's compatibility form. Two numbers stay separate: `3.5 t` is
 * not `35 t`. A name that is only punctuation stays unchanged.
 * @param {string} name
 */
export function comparable(name) {
  const folded = foldText(name);
  return folded.replace(BETWEEN_NUMBERS, '|').replace(IGNORED_CHARACTERS, '') || folded;
}

/** @param {Label} label @param {MatchedPart} how @returns {readonly string[]} */
function namesOf(label, how) {
  if (how === 'key') return [label.key];
  if (how === 'name') return [label.name];
  if (how === 'alias') return label.aliases;
  // the short names of most signs are words; a short name that is a number would be taken for an id
  return label.short === '' || /^\p{Nd}+$/u.test(label.short) ? [] : [label.short];
}

/**
 * @typedef {object} Finder
 * @property {(word: string) => {label: Label, how: MatchedPart}|null} find   the label that a word names
 * @property {(text: string, among: readonly Label[]) => Label[]} search   the labels that match a text, best first; an empty text matches all, in their order
 */

/** @type {WeakMap<readonly Label[], Finder>} */
const finders = new WeakMap();

/**
 * `find` looks in this order: key; name; alias; short name unless it is a number; id, such as `14`, `00014`, `class
 * 14`, `#14`. For a merged label it returns the label that replaces it. It finds hidden labels too.
 *
 * @param {readonly Label[]} labels   must not be changed later
 * @returns {Finder} the same object for the same list
 */
export function labelFinder(labels) {
  const cached = finders.get(labels);
  if (cached) return cached;
  const currentLabels = labelsById(labels);
  /** @type {Map<string, {label: Label, how: MatchedPart}>} */
  const labelsByName = new Map();
  for (const merged of [false, true]) {
    for (const how of /** @type {const} */ (['key', 'name', 'alias', 'short'])) {
      for (const label of labels) {
        if ((label.merged_into !== null) !== merged) continue;
        for (const word of namesOf(label, how)) {
          const name = comparable(word);
          if (!labelsByName.has(name)) labelsByName.set(name, { label: currentLabels.get(label.id) ?? label, how });
        }
      }
    }
  }

  /** @type {Finder['find']} */
  function find(word) {
    const known = labelsByName.get(comparable(word));
    if (known) return known;
    const number = NUMBER.exec(word.trim());
    const label = number && currentLabels.get(Number(number[1]));
    return label ? { label, how: 'number' } : null;
  }

  /** @type {Map<number, {name: string, parts: string[], others: string[], joined: string[]}>} */
  const index = new Map();
  /** @param {Label} label */
  function indexOf(label) {
    let known = index.get(label.id);
    if (!known) {
      const name = foldText(label.name);
      const others = [label.key, label.short, ...label.aliases].map(foldText);
      known = {
        name,
        parts: split(name),
        others: others.flatMap(split),
        joined: [label.name, label.key, ...label.aliases].map(comparable),
      };
      index.set(label.id, known);
    }
    return known;
  }

  /**
   * Names that contain a typed number come first, before the label with that id: typing 40 and Enter means the speed
   * limit, not label 40. Then exact matches, names that begin with the text, words of the name that begin with its
   * words, names that contain them, aliases, and matches without spaces.
   * @type {Finder['search']}
   */
  function search(text, among) {
    const wanted = foldText(text.trim());
    if (wanted === '') return [...among];
    const numbered = /^#\s*(\d{1,9})$/.exec(wanted);
    if (numbered) return among.filter(({ id }) => id === Number(numbered[1]));
    const typedWords = wanted.split(/\s+/);
    const exactMatch = find(text)?.label.id;
    const compact = comparable(text);
    /** @param {Label} label */
    const rank = (label) => {
      const { name, parts, others, joined } = indexOf(label);
      if (/^\d+$/.test(wanted) && parts.includes(wanted)) return 0;
      if (label.id === exactMatch) return 1;
      if (name.startsWith(wanted)) return 2;
      if (typedWords.every((word) => parts.some((part) => part.startsWith(word)))) return 3;
      if (typedWords.every((word) => name.includes(word))) return 4;
      if (typedWords.every((word) => parts.some((part) => part.startsWith(word)) || others.some((part) => part.startsWith(word)))) return 5;
      return joined.some((one) => one.includes(compact)) ? 6 : 7;
    };
    return among
      .map((label) => ({ label, rank: rank(label) }))
      .filter((found) => found.rank < 7)
      .sort((a, b) => a.rank - b.rank || a.label.id - b.label.id)
      .map((found) => found.label);
  }

  const finder = { find, search };
  finders.set(labels, finder);
  return finder;
}

/** A text for comparison: without case, in Unicode's compatibility form. @param {string} text */
const foldText = (text) => [...text.normalize('NFKC')].map(foldCase).join('');

/** @param {string} text */
const split = (text) => text.split(/[\s/(),._-]+/).filter(Boolean);

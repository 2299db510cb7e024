// @ts-check
/** Folds events that repeat from frame to frame into one line: a gap of fifty frames is one event. Pure. */

/** @typedef {import('./plain_words.js').Sentence} Sentence */
/** @typedef {{frame: number, last: number, kind: string, sentences: Sentence[]}} Stretch   `sentences` in frame order */

/** Kinds of events that can repeat; all others happen once. */
const REPEATING = new Set(['rejected', 'relocalised', 'unlearned']);
/** Minimum number of events to fold: two lines say more than one folded line. */
const LEAST = 3;

/**
 * Sentences grouped by kind over neighbouring frames, by first frame.
 *
 * @param {readonly Sentence[]} sentences   in frame order
 * @returns {Stretch[]}
 */
export function stretchesOf(sentences) {
  /** @type {Stretch[]} */
  const found = [];
  /** @type {Map<string, Stretch>} */
  const going = new Map();
  for (const sentence of sentences) {
    const before = going.get(sentence.kind);
    if (before && sentence.frame - before.last <= 1) {
      before.last = sentence.frame;
      before.sentences.push(sentence);
      continue;
    }
    const begun = alone(sentence);
    found.push(begun);
    if (REPEATING.has(sentence.kind)) going.set(sentence.kind, begun);
  }
  return found.flatMap((one) => (one.sentences.length < LEAST ? one.sentences.map(alone) : [one])).sort((a, b) => a.frame - b.frame);
}

/** @param {Sentence} sentence @returns {Stretch} */
function alone(sentence) {
  return { frame: sentence.frame, last: sentence.frame, kind: sentence.kind, sentences: [sentence] };
}

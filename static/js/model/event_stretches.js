// @ts-check
/** Events that repeat from frame to frame as one line: a gap of fifty frames is one thing that happened. Pure. */

/** @typedef {import('./plain_words.js').Sentence} Sentence */
/** @typedef {{frame: number, last: number, kind: string, sentences: Sentence[]}} Stretch   `sentences` in order of frames */

/** Kinds that can repeat; all others happen once. */
const REPEATING = new Set(['rejected', 'relocalised', 'unlearned']);
/** Shorter ones stay apart: two lines say more than one with a fold. */
const LEAST = 3;

/**
 * Sentences of one kind in neighbouring frames together, by their first frame.
 *
 * @param {readonly Sentence[]} sentences   in order of frames
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

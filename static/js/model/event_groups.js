// @ts-check
/** Folds events that repeat from frame to frame into one line: a gap of fifty frames is one event. Pure. */

/** @typedef {import('./describe_events.js').Sentence} Sentence */
/** @typedef {{frame: number, last: number, kind: string, sentences: Sentence[]}} EventGroup   `sentences` in frame order */

/** Kinds of events that can repeat; all others happen once. */
const REPEATING = new Set(['rejected', 'relocalised', 'unlearned']);
/** Minimum number of events to fold: two lines say more than one folded line. */
const MIN_FOLDED_EVENTS = 3;

/**
 * Sentences grouped by kind over neighbouring frames, by first frame.
 *
 * @param {readonly Sentence[]} sentences   in frame order
 * @returns {EventGroup[]}
 */
export function groupEvents(sentences) {
  /** @type {EventGroup[]} */
  const found = [];
  /** @type {Map<string, EventGroup>} */
  const openGroups = new Map();
  for (const sentence of sentences) {
    const before = openGroups.get(sentence.kind);
    if (before && sentence.frame - before.last <= 1) {
      before.last = sentence.frame;
      before.sentences.push(sentence);
      continue;
    }
    const group = groupOfOne(sentence);
    found.push(group);
    if (REPEATING.has(sentence.kind)) openGroups.set(sentence.kind, group);
  }
  return found
    .flatMap((one) => (one.sentences.length < MIN_FOLDED_EVENTS ? one.sentences.map(groupOfOne) : [one]))
    .sort((a, b) => a.frame - b.frame);
}

/** @param {Sentence} sentence @returns {EventGroup} */
function groupOfOne(sentence) {
  return { frame: sentence.frame, last: sentence.frame, kind: sentence.kind, sentences: [sentence] };
}

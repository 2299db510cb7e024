// @ts-check
/** The events of a track in plain sentences, from its lane. Pure. */

import { count, figure, plural } from './format.js';

/** @typedef {import('../types.js').TrackLane} TrackLane */
/** @typedef {{frame: number, kind: string, text: string}} Sentence   `text` begins in lower case and does not name the frame */

/** Typical factors for a sign that is tracked well. They decide only which factor is named as the reason. */
const TYPICAL_FACTORS = { symmetry: 1.5, bits: 8, position: 3 };

/**
 * One sentence per event, in frame order: the engine's own if it has one, else a sentence for births, first verdicts
 * and learning, which the engine stores only as numbers.
 *
 * @param {TrackLane} lane
 * @returns {Sentence[]}
 */
export function eventSentences(lane) {
  /** @type {Sentence[]} */
  const found = lane.events.map(({ frame, kind, text }) => ({ frame, kind, text: shorten(text, lane.id) }));
  const reported = new Set(lane.events.map(({ frame }) => frame));
  const kinds = new Set(lane.events.map(({ kind }) => kind));
  for (let i = 0; i < lane.frame.length; i += 1) {
    const frame = lane.frame[i];
    if (i === 0 && !kinds.has('born')) found.push({ frame, kind: 'born', text: birth(lane) });
    if (lane.confident[i] === false && !reported.has(frame)) found.push({ frame, kind: 'rejected', text: rejection(lane, i) });
    if (lane.unlearned[i] > 0)
      found.push({ frame, kind: 'unlearned', text: `the online detector unlearned ${plural(lane.unlearned[i], 'sample')}` });
    if (i > 0 && i === lane.frame.length - 1 && !kinds.has('died')) found.push({ frame, kind: 'ended', text: 'last frame of the track' });
  }
  return found.sort((a, b) => a.frame - b.frame);
}

/**
 * The reason for a verdict, with all three factors.
 *
 * @param {TrackLane} lane
 * @param {number} i      index in the columns
 * @returns {string|null} null: the gate did not judge this frame
 */
export function describeVerdict(lane, i) {
  const likelihood = lane.l_positive[i];
  if (lane.confident[i] === null || likelihood === null) return null;
  const relation = lane.confident[i] ? '<' : relationSign(likelihood, lane.tau);
  const verdict = lane.confident[i] ? 'Prediction confident' : 'Prediction rejected';
  const factors = [lane.symmetry[i], lane.hash_distance[i], lane.position_distance[i]];
  const names = ['symmetry', 'appearance distance, bits', 'position'];
  const known = factors.map((value, k) => (value === null ? null : `${shortNumber(value)} (${names[k]})`)).filter((text) => text !== null);
  // parameters may shift a factor before the multiplication: write a product only if it is exact
  const product = factors.reduce((/** @type {number} */ all, value) => all * (value ?? Number.NaN), 1);
  const isExact = Math.abs(product - likelihood) <= 0.01 * Math.abs(likelihood);
  const sum = isExact ? `${shortNumber(likelihood)} = ${known.join(' × ')}` : shortNumber(likelihood);
  return `${verdict}: gate score ${sum}${isExact ? ',' : ''} ${relation} tau ${shortNumber(lane.tau)}${isExact || known.length === 0 ? '' : `, from ${known.join(', ')}`}.`;
}

/**
 * The origin of the first factor of a verdict. A symmetry below the run's floor counts as the floor, so the factor is
 * not always the reciprocal of the measured value.
 *
 * @param {TrackLane} lane
 * @param {number} i      index in the columns
 * @returns {string|null} null: the gate did not judge this frame
 */
export function describeSymmetry(lane, i) {
  const measured = lane.symmetry_magnitude[i];
  const factor = lane.symmetry[i];
  if (measured === null || factor === null) return null;
  const counted = Math.max(measured, lane.symmetry_floor);
  return `The crop’s mirror symmetry is ${shortNumber(measured)}${countsAs(measured, lane.symmetry_floor)}: the factor is 1 / ${shortNumber(counted)} = ${shortNumber(factor)}.`;
}

/** The suffix after the mirror symmetry of a crop if the floor counts instead. @param {number} measured @param {number} floor   the run's symmetry_floor */
export const countsAs = (measured, floor) => (measured < floor ? `, which counts as ${shortNumber(floor)} (symmetry_floor)` : '');

/** The hint of the lane of the first factor. @param {number} floor   the run's symmetry_floor */
export const symmetryHint = (floor) =>
  `First factor: 1 / mirror symmetry of the crop, at least ${shortNumber(floor)} (symmetry_floor); low is good`;

/** The relation of a rejected L to tau; the engine's own sentences use the same. @param {number|null} likelihood @param {number} tau */
const relationSign = (likelihood, tau) => (likelihood === tau ? '=' : '>');

/**
 * The origin of the box in a frame.
 *
 * @param {TrackLane} lane
 * @param {number} i      index in the columns
 * @returns {string}
 */
export function describeSource(lane, i) {
  const score = lane.score[i];
  const raw = lane.raw_score[i];
  if (lane.source[i] === 2)
    return `Re-detected by the online detector: f = ${shortNumber(lane.decision[i])}, probability ${shortNumber(lane.probability[i])}.`;
  if (lane.source[i] === 1) return 'Predicted: no measurement replaced the prediction.';
  if (raw === null || score === null) return 'Detected.';
  return `Score ${shortNumber(score)} = detector ${shortNumber(raw)} ${score < raw ? '-' : '+'} prior ${shortNumber(Math.abs(score - raw))}.`;
}

/** @param {TrackLane} lane @param {number} i */
function rejection(lane, i) {
  const reason = `L = ${shortNumber(lane.l_positive[i])} ${relationSign(lane.l_positive[i], lane.tau)} ${shortNumber(lane.tau)}, ${decidingFactor(lane, i)}`;
  const probability = lane.probability[i];
  if (lane.source[i] === 2) {
    const sure = probability === null ? '' : ` (probability ${shortNumber(probability)})`;
    return `prediction rejected, ${reason}; re-detected${sure}`;
  }
  const answer = lane.source[i] === 0 ? 'a detection replaced it' : 'nothing better was found near it';
  return `prediction rejected, ${reason}; ${answer}`;
}

/** The factor with the largest weight. @param {TrackLane} lane @param {number} i */
function decidingFactor(lane, i) {
  const symmetry = lane.symmetry[i] ?? 0;
  const bits = lane.hash_distance[i] ?? 0;
  const position = lane.position_distance[i] ?? 0;
  const weights = [
    { weight: symmetry / TYPICAL_FACTORS.symmetry, text: `symmetry ${shortNumber(lane.symmetry_magnitude[i])} is low` },
    { weight: bits / TYPICAL_FACTORS.bits, text: `its appearance has changed in ${Math.round(bits)} of 64 bits` },
    { weight: position / TYPICAL_FACTORS.position, text: `it is ${shortNumber(position)} from the last result` },
  ];
  return weights.reduce((a, b) => (b.weight > a.weight ? b : a)).text;
}

/** @param {TrackLane} lane */
function birth(lane) {
  const score = lane.score[0];
  return score === null ? 'the track begins' : `the track begins with a detection, score ${shortNumber(score)}`;
}

/**
 * The engine's sentence without the name of its track, which the inspector already shows.
 *
 * @param {string} text
 * @param {number} track
 */
function shorten(text, track) {
  let plain = text.replace(` of track ${track} `, ' ');
  plain = plain.replace(new RegExp(`^Track ${track} (?:is |has had (?=no ))?`), '');
  plain = plain.replace(/\.$/, '');
  return plain.charAt(0).toLowerCase() + plain.slice(1);
}

/** @param {number|null|undefined} value @returns {string} three digits */
export function shortNumber(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size >= 1e6) return 'very large';
  if (size >= 1000) return count(Math.round(value));
  return figure(value);
}

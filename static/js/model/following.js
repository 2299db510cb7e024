// @ts-check
/**
 * A follow of a sign: the server's proposals so far, and the part of them that would be accepted. Pure.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').Follow} Follow
 * @typedef {import('../types.js').FollowAnchor} FollowAnchor
 * @typedef {import('../types.js').FollowedBox} FollowedBox
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 *
 * @typedef {{box: Box, confidence: number, source: 'anchor'|'detected'|'matched'|'predicted'}} Proposal
 *
 * @typedef {object} Following
 * @property {string|null} id        null: the server has not answered yet
 * @property {string} key            the track
 * @property {FollowAnchor[]} anchors   in frame order
 * @property {'forward'|'backward'|'between'|null} only
 * @property {number} first          no proposal is before this frame
 * @property {number|null} last      no proposal is after this frame; null: the end of the video
 * @property {'queued'|'running'|'complete'|'failed'|'cancelled'} state
 * @property {string|null} error
 * @property {string} note           what the server does besides following; empty: nothing
 * @property {Record<number, Proposal>} proposals   by frame
 * @property {import('../types.js').FollowEnding[]} endings
 * @property {number} next           number of the next part to request
 * @property {number|null} from      the user cut off the proposals before this frame; null: none
 * @property {number|null} to        the user cut off the proposals after this frame; null: none
 */
import { keyFramesOf } from './documents.js';

/** Maximum difference between accepted and proposed boxes at each edge, px. */
const TOLERANCE_PX = 0.5;

/** @param {Pick<Following, 'key'|'anchors'|'only'|'first'|'last'>} request @returns {Following} */
export const newFollowing = (request) => ({
  ...request,
  id: null,
  state: 'queued',
  error: null,
  note: '',
  endings: [],
  next: 0,
  from: null,
  to: null,
  proposals: Object.fromEntries(
    request.anchors.map(({ frame, box }) => [frame, { box, confidence: 1, source: /** @type {const} */ ('anchor') }]),
  ),
});

/**
 * The follow with an answer of the server added.
 * @param {Following} following
 * @param {Follow} answer
 * @returns {Following}
 */
export function withAnswer(following, answer) {
  const proposals = { ...following.proposals };
  for (const [frame, x1, y1, x2, y2, confidence, source] of answer.proposals) {
    proposals[frame] = { box: [x1, y1, x2, y2], confidence, source };
  }
  for (const { direction, frame: end } of answer.endings) {
    for (const frame of Object.keys(proposals).map(Number)) {
      // beyond the end, the engine searched for a sign that did not reappear
      if (direction === 'forward' ? frame > end : frame < end) delete proposals[frame];
    }
  }
  const { id, state, error, note, endings, next } = answer;
  return { ...following, id, state, error, note, endings, next, proposals };
}

/** Whether more may come. @param {Following} following */
export const isInProgress = ({ state }) => state === 'queued' || state === 'running';

/**
 * The frames that would be accepted: those around the anchors up to the first gap, without those cut off.
 * @param {Following} following
 * @returns {{first: number, last: number}}
 */
export function acceptedSpan({ anchors, proposals, from, to }) {
  let first = Math.max(anchors[0].frame, from ?? 0);
  let last = Math.min(anchors[anchors.length - 1].frame, to ?? Infinity);
  while (proposals[first - 1] && (from === null || first - 1 >= from)) first -= 1;
  while (proposals[last + 1] && (to === null || last + 1 <= to)) last += 1;
  return { first, last };
}

/** The proposal of a frame, if it would be accepted. @param {Following} following @param {number} frame @returns {Proposal|null} */
export function proposalAt(following, frame) {
  const { first, last } = acceptedSpan(following);
  return first <= frame && frame <= last ? (following.proposals[frame] ?? null) : null;
}

/** Number of frames that would be accepted besides the anchors. @param {Following} following */
export function proposedFrameCount(following) {
  const { first, last } = acceptedSpan(following);
  return last - first + 1 - following.anchors.filter(({ frame }) => first <= frame && frame <= last).length;
}

/**
 * Cut off the proposals before or after a frame; anchors always stay.
 * @param {Following} following
 * @param {'from'|'to'} end
 * @param {number} frame
 * @returns {Following}
 */
export function withCut(following, end, frame) {
  const { anchors } = following;
  const limit = end === 'from' ? Math.min(frame, anchors[anchors.length - 1].frame) : Math.max(frame, anchors[0].frame);
  return { ...following, [end]: limit };
}

/**
 * The fewest boxes whose linear interpolation stays within a tolerance of all boxes. Frames in `must` are kept.
 * @param {readonly {frame: number, box: Box}[]} boxes   in frame order
 * @param {ReadonlySet<number>} must   frames
 * @param {number} [tolerance]   px at each edge
 * @returns {{frame: number, box: Box}[]}
 */
export function thinBoxes(boxes, must, tolerance = TOLERANCE_PX) {
  if (boxes.length === 0) return [];
  const thinned = [boxes[0]];
  let index = 0;
  while (index < boxes.length - 1) {
    let next = index + 1;
    while (next + 1 < boxes.length && !must.has(boxes[next].frame) && isNear(boxes, index, next + 1, tolerance)) next += 1;
    thinned.push(boxes[next]);
    index = next;
  }
  return thinned;
}

/**
 * Whether the boxes between two are near the interpolation between these two.
 * @param {readonly {frame: number, box: Box}[]} boxes
 * @param {number} a
 * @param {number} b
 * @param {number} tolerance
 */
function isNear(boxes, a, b, tolerance) {
  const [first, last] = [boxes[a], boxes[b]];
  for (let i = a + 1; i < b; i += 1) {
    const share = (boxes[i].frame - first.frame) / (last.frame - first.frame);
    if (boxes[i].box.some((edge, k) => Math.abs(first.box[k] + share * (last.box[k] - first.box[k]) - edge) > tolerance)) return false;
  }
  return true;
}

/**
 * The operation that accepts the proposals.
 * @param {Following} following
 * @param {number} frame   the cursor
 * @returns {Command|null} null: there are only anchors
 */
export function acceptCommand(following, frame) {
  if (proposedFrameCount(following) === 0) return null;
  const { first, last } = acceptedSpan(following);
  const must = new Set(following.anchors.map((anchor) => anchor.frame));
  const dense = [];
  for (let k = first; k <= last; k += 1) if (following.proposals[k]) dense.push({ frame: k, box: following.proposals[k].box });
  const boxes = thinBoxes(dense, must).map((thinned) => ({ ...thinned, anchor: must.has(thinned.frame) }));
  return boxes.some(({ anchor }) => anchor) ? { name: 'follow', frame, key: following.key, boxes } : null;
}

/**
 * The nearest boxes before and after a frame that a person has set by hand. Only the frames between them are followed
 * again.
 * @param {TrackDoc|null} doc
 * @param {number} frame
 * @returns {{before: FollowAnchor|null, after: FollowAnchor|null}}
 */
export function anchorsAround(doc, frame) {
  const frames =
    doc === null ? [] : keyFramesOf(doc).filter((k) => doc.keys[k].box !== null && !doc.keys[k].followed && !doc.keys[k].outside);
  /** @param {number|undefined} k @returns {FollowAnchor|null} */
  const anchor = (k) => {
    const box = doc !== null && k !== undefined ? doc.keys[k].box : null;
    return box && k !== undefined ? { frame: k, box } : null;
  };
  return { before: anchor(frames.filter((k) => k < frame).at(-1)), after: anchor(frames.find((k) => k > frame)) };
}

/**
 * The range in which a track may be followed from a frame. It ends where a person has marked the track as outside.
 * @param {TrackDoc|null} doc
 * @param {number} frame
 * @returns {{first: number, last: number|null}}
 */
export function followRange(doc, frame) {
  let first = 0;
  /** @type {number|null} */ let last = null;
  const frames = doc === null ? [] : keyFramesOf(doc);
  frames.forEach((k, i) => {
    if (!doc?.keys[k].outside) return;
    const visibleAgain = frames[i + 1] ?? Infinity;
    if (visibleAgain <= frame) first = Math.max(first, visibleAgain);
    else if (k > frame && last === null) last = k - 1;
  });
  return { first, last };
}

/**
 * The request to follow a track from a box.
 * @param {TrackDoc|null} doc      null: nobody has changed the track
 * @param {string} key
 * @param {FollowAnchor} anchor
 * @param {'forward'|'backward'|null} only
 * @returns {Pick<Following, 'key'|'anchors'|'only'|'first'|'last'>}
 */
export function requestFrom(doc, key, anchor, only) {
  const range = followRange(doc, anchor.frame);
  const { before, after } = anchorsAround(doc, anchor.frame);
  const earlier = only === 'forward' || (before && before.frame < range.first) ? null : before;
  const later = only === 'backward' || (after && range.last !== null && after.frame > range.last) ? null : after;
  return {
    key,
    only,
    anchors: [earlier, anchor, later].flatMap((one) => (one ? [one] : [])),
    first: earlier ? earlier.frame : range.first,
    last: later ? later.frame : range.last,
  };
}

/**
 * The same request with one more anchor: a correction of a proposal.
 * @param {Following} following
 * @param {FollowAnchor} anchor
 * @returns {Pick<Following, 'key'|'anchors'|'only'|'first'|'last'>}
 */
export function requestWith({ key, anchors, only, first, last }, anchor) {
  const others = anchors.filter(({ frame }) => frame !== anchor.frame);
  const all = [...others, anchor].sort((a, b) => a.frame - b.frame);
  return { key, only, anchors: all, first: Math.min(first, anchor.frame), last: last === null ? null : Math.max(last, anchor.frame) };
}

/**
 * The state of a follow in one or two sentences.
 * @param {Following} following
 * @param {string} name   name of the track, as shown
 * @returns {string}
 */
export function describeFollowing(following, name) {
  if (following.state === 'failed' || following.state === 'cancelled')
    return `Track ${name} could not be followed: ${following.error ?? 'it was stopped.'}`;
  const { first, last } = acceptedSpan(following);
  const frames = proposedFrameCount(following);
  const span = frames === 0 ? '' : `frames ${first} to ${last}, ${frames} new`;
  if (isInProgress(following)) return `Following track ${name}${span ? `: ${span}` : ''}${following.note && ` · ${following.note}`}`;
  const why = following.endings.map(({ sentence }) => sentence).join(' ');
  return `${span ? `Proposal for track ${name}: ${span}.` : `Track ${name} is not found in another frame.`}${why ? ` ${why}` : ''}`;
}

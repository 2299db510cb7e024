// @ts-check
/**
 * Permissions, assignments, and the history of a track as text. Pure.
 *
 * @typedef {import('../types.js').Assignment} Assignment
 * @typedef {import('../types.js').Session} Session
 * @typedef {import('../types.js').TrackDifference} TrackDifference
 * @typedef {import('../types.js').Label} Label
 */
import { capitalized } from './format.js';
import { labelName } from './labels.js';
import { listNames, trackName } from './track_name.js';

const ROLES = /** @type {const} */ (['viewer', 'annotator', 'reviewer', 'admin']);
/** @typedef {typeof ROLES[number]} Role */

/** Whether the signed-in person has at least a role. Always true in a library without people. @param {Session|null} session @param {Role} minRole */
export const hasRole = (session, minRole) => !session?.person || ROLES.indexOf(session.person.role) >= ROLES.indexOf(minRole);

/** Why the person cannot change anything; null: they can. @param {Session|null} session @returns {string|null} */
export const readOnlyReason = (session) =>
  hasRole(session, 'annotator')
    ? null
    : 'You are a viewer here: you can look at everything and change nothing. Ask an administrator for another role.';

/** @type {Record<Assignment['state'], string>} */
export const STATES = { assigned: 'To do', in_review: 'In review', returned: 'Returned', done: 'Done' };
/** @type {Record<Assignment['state'], number>} */
const ORDER = { returned: 0, assigned: 1, in_review: 2, done: 3 };

/** Assignments that wait for a person: returned ones first, then by age. @param {readonly Assignment[]} assignments @param {string} name */
export const waitingAssignments = (assignments, name) =>
  inOrder(assignments.filter(({ person, state }) => person === name && (state === 'returned' || state === 'assigned')));

/** Assignments that others have handed in. @param {readonly Assignment[]} assignments @param {string} name */
export const assignmentsToReview = (assignments, name) =>
  inOrder(assignments.filter(({ person, state }) => person !== name && state === 'in_review'));

/** @param {Assignment[]} found */
const inOrder = (found) => found.sort((a, b) => ORDER[a.state] - ORDER[b.state] || a.id - b.id);

/**
 * The next assignment: the person's own after the open one, else, for a reviewer, one that was handed in.
 *
 * @param {readonly Assignment[]} assignments
 * @param {Session|null} session
 * @param {number|null} open   id of the open assignment
 * @returns {Assignment|null}
 */
export function nextAssignment(assignments, session, open) {
  const name = session?.person?.name;
  if (name === undefined) return null;
  const found = [...waitingAssignments(assignments, name), ...(hasRole(session, 'reviewer') ? assignmentsToReview(assignments, name) : [])];
  const next = found[found.findIndex(({ id }) => id === open) + 1] ?? found[0] ?? null;
  return next?.id === open ? null : next;
}

/**
 * The assignment of the review screen: the person's own for that video, else one that others have handed in.
 *
 * @param {readonly Assignment[]} assignments
 * @param {Session|null} session
 * @param {string} video
 * @param {number} frame   of several assignments for a video, the one with this frame is chosen
 * @returns {Assignment|null}
 */
export function currentAssignment(assignments, session, video, frame) {
  const name = session?.person?.name;
  if (name === undefined) return null;
  const candidates = assignments.filter(
    (one) =>
      one.video_id === video &&
      one.state !== 'done' &&
      (one.person === name || (hasRole(session, 'reviewer') && one.state === 'in_review')),
  );
  const containsFrame = /** @param {Assignment} one */ (one) => one.first <= frame && (one.stop === null || frame < one.stop);
  const rank = /** @param {Assignment} one */ (one) => (containsFrame(one) ? 0 : 2) + (one.person === name ? 0 : 1);
  return candidates.sort((a, b) => rank(a) - rank(b) || a.first - b.first)[0] ?? null;
}

/** @param {Pick<Assignment, 'first'|'stop'>} assignment */
export function assignedFrames({ first, stop }) {
  if (stop === null) return first === 0 ? 'all frames' : `from frame ${first}`;
  return `frames ${first} to ${stop - 1}`;
}

/** A difference in one line. @param {TrackDifference} difference @param {readonly Label[]} labels @returns {string} */
export function describeDifference({ what, before, after, more }, labels) {
  const rest = more > 0 ? ` and ${more} more` : '';
  if (what === 'label') return `Label: ${describeLabel(before, labels)} → ${describeLabel(after, labels)}`;
  if (what === 'review') return `Verdict: ${VERDICTS[before] ?? before} → ${VERDICTS[after] ?? after}`;
  if (what === 'merged into') return after === null ? 'Merge taken back' : `Merged into track ${trackName(after)}`;
  if (typeof after === 'boolean') return after ? capitalized(what) : `No longer ${what}`;
  if (what === 'boxes') return describeBoxes(before, after) + rest;
  if (what === 'notes' || what === 'attributes') return describePairs(what, before, after) + rest;
  if (Array.isArray(before) && Array.isArray(after)) {
    const [removed, added] = [missing(before, after), missing(after, before)];
    return `${capitalized(what)}: ${[added.length ? `set at ${listSome(added)}` : '', removed.length ? `removed at ${listSome(removed)}` : ''].filter(Boolean).join(', ')}`;
  }
  return `${capitalized(what)} changed${rest}`;
}

/** @type {Record<string, string>} */
const VERDICTS = { open: 'undecided', accepted: 'accepted', rejected: 'false positive', needs_work: 'needs work' };

/** @param {any} id @param {readonly Label[]} labels */
const describeLabel = (id, labels) => (id === null ? 'the engine’s' : labelName(labels, id));

/** @param {Record<string, number[]>} before @param {Record<string, number[]>} after */
function describeBoxes(before, after) {
  const set = Object.keys(after);
  const removed = Object.keys(before).filter((frame) => !(frame in after));
  const single = set.length === 1 && removed.length === 0 ? set[0] : null;
  if (single !== null) {
    const now = boxText(after[single]);
    return before[single] ? `Box in frame ${single}: ${boxText(before[single])} → ${now}` : `Box in frame ${single}: ${now}`;
  }
  return `Boxes: ${[set.length ? `set in frames ${listSome(set)}` : '', removed.length ? `removed in frames ${listSome(removed)}` : ''].filter(Boolean).join(', ')}`;
}

/** @param {string} what @param {Record<string, unknown>} before @param {Record<string, unknown>} after */
function describePairs(what, before, after) {
  const named = what === 'attributes';
  const lines = [...new Set([...Object.keys(before), ...Object.keys(after)])].map((key) => {
    const [old, now] = [before[key], after[key]];
    const text = now === undefined ? `“${old}” removed` : old === undefined ? `“${now}”` : `“${old}” → “${now}”`;
    return named ? `${key} ${text}` : text;
  });
  return `${named ? 'Attributes' : 'Note'}: ${lines.join('; ')}`;
}

/** @param {number[]} box */
const boxText = (box) => box.map((value) => Math.round(value * 10) / 10).join(', ');
/** @param {readonly unknown[]} list @param {readonly unknown[]} other */
const missing = (list, other) => list.filter((one) => !other.some((same) => JSON.stringify(same) === JSON.stringify(one)));
/** @param {readonly unknown[]} list */
const listSome = (list) =>
  listNames(
    list.map((one) => (Array.isArray(one) ? one.slice(1).join('–') : String(one))),
    5,
  );

/** Decided tracks per hour of work; null: too little data. @param {{decided: number, hours: number}} worker */
export const tracksPerHour = ({ decided, hours }) => (hours >= 0.05 && decided > 0 ? Math.round(decided / hours) : null);

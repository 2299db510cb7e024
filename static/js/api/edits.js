// @ts-check
/** Routes of corrections: edits, follows, corrections adopted from an earlier run. */

import { RUN } from './runs.js';

/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('../types.js').Command} Command */
/** @typedef {import('../types.js').Follow} Follow */
/** @typedef {import('./http.js').Call} Call */
/** @typedef {{kept: string[], not_needed: string[], conflicts: {key: string, reason: string, frame: number}[]}} Adoption */

const FOLLOW = /** @type {const} */ ({
  id: 'string',
  key: 'string',
  state: 'string',
  anchors: 'array',
  proposals: 'array',
  endings: 'array',
  next: 'number',
});
const ADOPTION = /** @type {const} */ ({ kept: 'array', not_needed: 'array', conflicts: 'array' });

/** @param {import('./http.js').Routes} routes */
export const editRoutes = ({ json, object }) => ({
  /** @param {string} run @param {string|null} [author] @param {Call} [call] @returns {Promise<import('../types.js').Annotation>} */
  annotation: (run, author, call) =>
    object('GET /runs/…/annotation', [run], { seq: 'number', docs: 'array' }, { ...call, query: { author } }),
  /**
   * @param {string} run
   * @param {{op_id: string, author: string, command: Command|{name: 'undo'|'redo', op_id: string}}} edit
   * @param {Record<string, number>} revisions   of every track that the command touches
   * @param {Call} [call]
   * @returns {Promise<import('../types.js').EditAnswer>}
   */
  edit(run, edit, revisions, call) {
    const match = Object.entries(revisions).map(([key, revision]) => `"${key}:${revision}"`);
    const headers = match.length ? { 'If-Match': match.join(', ') } : undefined;
    return object('POST /runs/…/edits', [run], { op_id: 'string', seq: 'number', docs: 'array' }, { ...call, body: edit, headers });
  },
  /** @param {string} video @param {string|null} author @param {Call} [call] @returns {Promise<Run>} a run without an engine, for drawing all tracks by hand */
  startByHand: (video, author, call) => object('POST /videos/…/runs/by-hand', [video], RUN, { ...call, body: { author } }),
  /** @param {string} run @param {{key: string, anchors: import('../types.js').FollowAnchor[], only: string|null, first: number, last: number|null, author: string|null}} wanted @param {Call} [call] @returns {Promise<Follow>} */
  startFollow: (run, wanted, call) => object('POST /runs/…/follows', [run], FOLLOW, { ...call, body: wanted }),
  /** @param {string} run @param {number} frame @param {Call} [call] @returns {Promise<void>} announces that a follow may start there */
  expectFollow: (run, frame, call) => json('POST /runs/…/follows/expected', [run], { ...call, body: { frame } }),
  /** @param {string} run @param {string|null} author @param {Call} [call] @returns {Promise<Follow|null>} */
  findFollow: async (run, author, call) =>
    (await object('GET /runs/…/follows', [run], { found: 'nullable' }, { ...call, query: { author } })).found,
  /** @param {string} id @param {number} after @param {number} wait   seconds @param {Call} [call] @returns {Promise<Follow>} */
  follow: (id, after, wait, call) => object('GET /follows/…', [id], FOLLOW, { ...call, query: { after, wait } }),
  /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
  dropFollow: (id, call) => json('DELETE /follows/…', [id], call),
  /** @param {string} run @param {number} after @param {Call} [call] @returns {Promise<{edits: import('../model/deleted.js').LogRow[]}>} at most 1,000 rows of the log after the number */
  edits: (run, after, call) => object('GET /runs/…/edits', [run], { edits: 'array' }, { ...call, query: { after } }),
  /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').Earlier|null>} */
  earlier: async (run, call) => (await object('GET /runs/…/earlier', [run], { found: 'nullable' }, call)).found,
  /** @param {string} run @param {string} from @param {string|null} author @param {Call} [call] @returns {Promise<Adoption>} */
  adopt: (run, from, author, call) =>
    object('POST /runs/…/adopt', [run], ADOPTION, { ...call, body: { from_run: from, author }, timeout: 120_000 }),
});

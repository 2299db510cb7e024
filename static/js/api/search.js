// @ts-check
/** Routes of the search across videos. */

import { expectList, expectObject } from './shapes.js';
import { queryText } from './http.js';

/** @typedef {import('../types.js').FoundTrack} FoundTrack */
/** @typedef {import('./http.js').Call} Call */
/** @typedef {{tracks: FoundTrack[], next: string|null, total: number, more: boolean, labels: {set: string, id: number, name: string}[], unread: number,
 *   unreadable: {run: string, run_name: string, video_name: string, message: string}[], unreadable_count: number}} SearchAnswer */
/** @typedef {{type: 'judge', review: import('../types.js').TrackDoc['review']}|{type: 'ignore', value: boolean}|{type: 'relabel', label: string}} TrackAction */
/** @typedef {{changed: number, operations: {run: string, op_id: string}[], stayed: number, sentences: string[], tracks: FoundTrack[]}} TracksDone */

const FOUND = /** @type {const} */ ({
  run: 'string',
  key: 'string',
  video: 'string',
  video_name: 'string',
  label: 'nullable',
  state: 'string',
  uncertainty: 'number',
  frame: 'number',
  box: 'array',
  revision: 'number',
  tags: 'array',
});
const DONE = /** @type {const} */ ({ changed: 'number', operations: 'array', stayed: 'number', sentences: 'array', tracks: 'array' });

const FOUND_PAGE = /** @type {const} */ ({
  tracks: 'array',
  next: 'nullable',
  total: 'number',
  more: 'boolean',
  unread: 'number',
  unreadable: 'array',
});

/** @param {import('./http.js').Routes} routes */
export const searchRoutes = ({ base, json, object }) => ({
  /** @param {string} query   as in the address of the page @param {{limit: number, cursor?: string|null}} page @param {Call} [call] @returns {Promise<SearchAnswer>} */
  search: async (query, { limit, cursor }, call) => {
    const params = new URLSearchParams(query);
    params.set('limit', String(limit));
    if (cursor) params.set('cursor', cursor);
    const answer = expectObject('GET /search', await json(`GET /search?${params}`, [], call), FOUND_PAGE);
    expectList('GET /search', answer.tracks, FOUND);
    return answer;
  },
  /** @param {Pick<FoundTrack, 'run'|'frame'|'box'>} track @param {number} size   longer side, px @returns {string} */
  searchCropUrl: ({ run, frame, box }, size) => `${base}/search/crop${queryText({ run, frame, box: box.join(','), size })}`,
  /** @param {{action_id: string, author: string|null, action: TrackAction, tracks: {run: string, key: string, revision: number}[]}} body @param {Call} [call] @returns {Promise<TracksDone>} */
  actOnTracks: (body, call) => object('POST /search/actions', [], DONE, { timeout: 120_000, ...call, body }),
  /** @param {{author: string|null, operations: {run: string, op_id: string}[]}} body @param {Call} [call] @returns {Promise<TracksDone>} */
  undoTracks: (body, call) => object('POST /search/undo', [], DONE, { timeout: 120_000, ...call, body }),
  /** @param {{videos: string[], add?: string[], remove?: string[]}} body @param {Call} [call] @returns {Promise<{changed: number}>} */
  tagVideos: (body, call) => object('POST /videos/tags', [], { changed: 'number' }, { timeout: 60_000, ...call, body }),
});

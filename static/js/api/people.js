// @ts-check
/** Routes of people: sign-out, accounts, assignments, histories, statistics of work. */

import { encode } from './http.js';
import { expectList, expectObject } from './shapes.js';

/** @typedef {import('../types.js').Assignment} Assignment */
/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */

const ASSIGNMENT = /** @type {const} */ ({
  id: 'number',
  video_id: 'string',
  video_name: 'string',
  person: 'string',
  state: 'string',
  comment: 'string',
  revision: 'number',
});

/** @param {(path: string, options?: import('./http.js').RequestOptions) => Promise<any>} json */
export function peopleRoutes(json) {
  /** @param {string} route @param {any} answer @returns {Assignment[]} */
  const assignments = (route, answer) => expectList(route, expectObject(route, answer, { assignments: 'array' }).assignments, ASSIGNMENT);
  return {
    /** @param {Call} [call] @returns {Promise<void>} */
    signOut: (call) => json('/session', { ...call, method: 'DELETE' }),
    /** @param {Call} [call] @returns {Promise<import('../types.js').Person[]>} */
    people: async (call) =>
      expectList('GET /people', expectObject('GET /people', await json('/people', call), { people: 'array' }).people, {
        name: 'string',
        role: 'string',
      }),
    /** @param {Call} [call] @returns {Promise<Assignment[]>} */
    assignments: async (call) => assignments('GET /assignments', await json('/assignments', call)),
    /** @param {{videos: string[], person: string, first: number, stop: number|null, comment: string}} wanted @param {Call} [call] @returns {Promise<Assignment[]>} */
    assign: async (wanted, call) => assignments('POST /assignments', await json('/assignments', { ...call, method: 'POST', body: wanted })),
    /** @param {Assignment} known   its version on the page @param {{state?: Assignment['state'], comment?: string, person?: string}} change @param {Call} [call] @returns {Promise<Assignment>} */
    changeAssignment: async (known, change, call) =>
      expectObject(
        'PATCH /assignments/…',
        await json(`/assignments/${known.id}`, { ...call, method: 'PATCH', body: { revision: known.revision, ...change } }),
        ASSIGNMENT,
      ),
    /** @param {number} id @param {Call} [call] @returns {Promise<void>} */
    removeAssignment: (id, call) => json(`/assignments/${id}`, { ...call, method: 'DELETE' }),
    /** @param {string} run @param {string} key @param {number|null} before @param {Call} [call] @returns {Promise<import('../types.js').TrackHistory>} */
    trackHistory: async (run, key, before, call) =>
      expectObject(
        'GET /runs/…/history',
        await json(`/runs/${encode(run)}/tracks/${encode(key)}/history`, { ...call, query: { before } }),
        {
          key: 'string',
          happened: 'array',
          more: 'nullable',
        },
      ),
    /** @param {string} name @param {number|null} before @param {Call} [call] @returns {Promise<import('../types.js').Activity>} */
    activity: async (name, before, call) =>
      expectObject('GET /people/…/activity', await json(`/people/${encode(name)}/activity`, { ...call, query: { before } }), {
        worker: 'object',
        done: 'array',
        more: 'nullable',
      }),
    /** @param {Call} [call] @returns {Promise<import('../types.js').Overview>} */
    overview: async (call) =>
      expectObject('GET /overview', await json('/overview', { timeout: 60_000, ...call }), {
        videos: 'number',
        tracks: 'number',
        people: 'array',
        unread: 'number',
      }),
    /** @param {Call} [call] @returns {Promise<import('../types.js').SecondOpinions>} */
    secondOpinions: async (call) =>
      expectObject('GET /second-opinions', await json('/second-opinions', call), {
        open: 'number',
        whole: 'object',
        labels: 'array',
        first: 'array',
        second: 'array',
        boxes: 'object',
        disputes: 'array',
        disputed: 'number',
      }),
    /** @param {{person: string, share: number}} wanted @param {Call} [call] @returns {Promise<{given: number, accepted: number, unread: number}>} */
    giveSecondOpinions: async (wanted, call) =>
      expectObject('POST /second-opinions', await json('/second-opinions', { timeout: 60_000, ...call, method: 'POST', body: wanted }), {
        given: 'number',
        accepted: 'number',
      }),
    /** @param {Call} [call] @returns {Promise<import('../types.js').NextLook>} */
    nextSecondOpinion: async (call) =>
      expectObject('GET /second-opinions/next', await json('/second-opinions/next', call), { look: 'nullable', left: 'number' }),
    /** @param {number} id @param {number|null} label   -1: none of the set's labels; null: no sign @param {Call} [call] @returns {Promise<void>} */
    answerSecondOpinion: (id, label, call) => json(`/second-opinions/${id}/answer`, { ...call, method: 'POST', body: { label } }),
  };
}

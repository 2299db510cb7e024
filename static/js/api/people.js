// @ts-check
/** Routes of people: sign-out, accounts, assignments, histories, statistics of work. */

/** @typedef {import('../types.js').Assignment} Assignment */
/** @typedef {import('./http.js').Call} Call */

const ASSIGNMENT = /** @type {const} */ ({
  id: 'number',
  video_id: 'string',
  video_name: 'string',
  person: 'string',
  state: 'string',
  comment: 'string',
  revision: 'number',
});

const OVERVIEW = /** @type {const} */ ({ videos: 'number', tracks: 'number', people: 'array', unread: 'number' });
const SECOND_OPINIONS = /** @type {const} */ ({
  open: 'number',
  whole: 'object',
  labels: 'array',
  first: 'array',
  second: 'array',
  boxes: 'object',
  disputes: 'array',
  disputed: 'number',
});

/** @param {import('./http.js').Routes} routes */
export const peopleRoutes = ({ json, list, object }) => ({
  /** @param {Call} [call] @returns {Promise<void>} */
  signOut: (call) => json('DELETE /session', [], call),
  /** @param {Call} [call] @returns {Promise<import('../types.js').Person[]>} */
  people: (call) => list('GET /people', [], { name: 'string', role: 'string' }, call, 'people'),
  /** @param {Call} [call] @returns {Promise<Assignment[]>} */
  assignments: (call) => list('GET /assignments', [], ASSIGNMENT, call, 'assignments'),
  /** @param {{videos: string[], person: string, first: number, stop: number|null, comment: string}} wanted @param {Call} [call] @returns {Promise<Assignment[]>} */
  assign: (wanted, call) => list('POST /assignments', [], ASSIGNMENT, { ...call, body: wanted }, 'assignments'),
  /** @param {Assignment} known   its version on the page @param {{state?: Assignment['state'], comment?: string, person?: string}} change @param {Call} [call] @returns {Promise<Assignment>} */
  changeAssignment: ({ id, revision }, change, call) =>
    object('PATCH /assignments/…', [id], ASSIGNMENT, { ...call, body: { revision, ...change } }),
  /** @param {number} id @param {Call} [call] @returns {Promise<void>} */
  removeAssignment: (id, call) => json('DELETE /assignments/…', [id], call),
  /** @param {string} run @param {string} key @param {number|null} before @param {Call} [call] @returns {Promise<import('../types.js').TrackHistory>} */
  trackHistory: (run, key, before, call) =>
    object(
      'GET /runs/…/tracks/…/history',
      [run, key],
      { key: 'string', happened: 'array', more: 'nullable' },
      { ...call, query: { before } },
    ),
  /** @param {string} name @param {number|null} before @param {Call} [call] @returns {Promise<import('../types.js').Activity>} */
  activity: (name, before, call) =>
    object('GET /people/…/activity', [name], { worker: 'object', done: 'array', more: 'nullable' }, { ...call, query: { before } }),
  /** @param {Call} [call] @returns {Promise<import('../types.js').Overview>} */
  overview: (call) => object('GET /overview', [], OVERVIEW, { timeout: 60_000, ...call }),
  /** @param {Call} [call] @returns {Promise<import('../types.js').SecondOpinions>} */
  secondOpinions: (call) => object('GET /second-opinions', [], SECOND_OPINIONS, call),
  /** @param {{person: string, share: number}} wanted @param {Call} [call] @returns {Promise<{given: number, accepted: number, unread: number}>} */
  giveSecondOpinions: (wanted, call) =>
    object('POST /second-opinions', [], { given: 'number', accepted: 'number' }, { timeout: 60_000, ...call, body: wanted }),
  /** @param {Call} [call] @returns {Promise<import('../types.js').NextLook>} */
  nextSecondOpinion: (call) => object('GET /second-opinions/next', [], { look: 'nullable', left: 'number' }, call),
  /** @param {number} id @param {number|null} label   -1: none of the set's labels; null: no sign @param {Call} [call] @returns {Promise<void>} */
  answerSecondOpinion: (id, label, call) => json('POST /second-opinions/…/answer', [id], { ...call, body: { label } }),
});

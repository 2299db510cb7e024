// @ts-check
/** Every route of the server as a typed function. Shapes: `../types.js`. All reject with `ApiError`. */

import {createSend, queryText, readJson} from './http.js';
import {labelRoutes} from './labels.js';
import {peopleRoutes} from './people.js';
import {searchRoutes} from './search.js';
import {expectColumns, expectList, expectObject} from './shapes.js';
import {upload} from './upload.js';

/** @typedef {import('../types.js').Video} Video */
/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('../types.js').Command} Command */
/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */
/** @typedef {{onProgress?: (sent: number, total: number) => void, signal?: AbortSignal}} Sending */
/** @typedef {{note: string, video_name: string, first: number, stop: number, offset: number, frame: number, track: string|null, expected: {id: string, expected: string, met: boolean, got: string}[], corrections: number, other_pictures: number, skipped: string[], engine_version: string}} BundleReport */
/** @typedef {{path: string, parent: string|null, folders: string[], videos: {name: string, path: string, size: number}[], truncated: boolean}} Folder   `truncated`: the first by name, there are more */
/** @typedef {{preset: string, parameters: Record<string, unknown>, first?: number, stop?: number|null, name?: string}} RunRequest */
/** @typedef {{id: string, name: string, count: number}} GroundTruth */
/** @typedef {import('../types.js').GroundTruthBox} GroundTruthBox */
/**
 * @typedef {object} Explanation
 * @property {{axis: [number, number, number, number]|null, matches: [number, number, number, number, number][], magnitude: number, size: [number, number]}|null} symmetry
 * @property {{crop: string, mean: string, distance: number}|null} hash
 * @property {number|null} l_positive
 * @property {number} tau
 */
/** @typedef {{kept: string[], not_needed: string[], conflicts: {key: string, reason: string, frame: number}[]}} Adoption */
/** @typedef {import('./compare-types.js').Comparison} Comparison */

/** @typedef {ReturnType<typeof createApi>} Api */

const VIDEO = /** @type {const} */ ({id: 'string', name: 'string', state: 'string', runs: 'number', warnings: 'array', review: 'object'});
const RUN = /** @type {const} */ ({id: 'string', video_id: 'string', state: 'string', preset: 'string', first: 'number', frames_done: 'number', summary: 'object'});
const OUTPUT = /** @type {const} */ ({id: 'string', kind: 'string', name: 'string', state: 'string', options: 'object', summary: 'object'});
const FOLLOW = /** @type {const} */ ({id: 'string', key: 'string', state: 'string', anchors: 'array', proposals: 'array', endings: 'array', next: 'number'});
const MODEL = /** @type {const} */ ({id: 'string', name: 'string', state: 'string', figures: 'object', lineage: 'object', active: 'boolean'});

/**
 * @param {{base?: string, fetch?: typeof fetch, signal?: AbortSignal}} [setup]
 *   base: before every path; signal: cancels everything that is under way
 */
export function createApi(setup = {}) {
  const base = setup.base ?? '/api';
  const send = createSend({base, fetch: setup.fetch ?? globalThis.fetch.bind(globalThis), signal: setup.signal});

  /**
   * @param {string} path
   * @param {import('./http.js').RequestOptions} [options]
   */
  const json = async (path, options) => readJson(await send(path, options));
  /** @param {string} part */
  const e = (part) => encodeURIComponent(part);

  return {
    base,
    ...labelRoutes(base, json),
    ...peopleRoutes(json),
    ...searchRoutes(base, json),

    // -- session and catalogue
    /** @param {Call} [call] @returns {Promise<import('../types.js').Session>} */
    session: async (call) => expectObject('GET /session', await json('/session', call), {version: 'string', author: 'string', roots: 'array', presets: 'array'}),
    /** @param {Call} [call] @returns {Promise<import('../types.js').Parameter[]>} */
    parameters: async (call) => expectList('GET /parameters', await json('/parameters', call), {section: 'string', name: 'string', type: 'string'}),

    // -- videos
    /** @param {Call} [call] @returns {Promise<Video[]>} */
    videos: async (call) => {
      const answer = expectObject('GET /videos', await json('/videos', call), {videos: 'array'});
      return expectList('GET /videos', answer.videos, VIDEO);
    },
    /** @param {{label?: string, attribute?: string, value?: string, state?: string}} wanted @param {Call} [call] @returns {Promise<{videos: Record<string, number>, left: number, unreadable: number}>} videos: tracks by id; left: not counted yet, to be asked again */
    matchingVideos: async (wanted, call) => expectObject('GET /videos/matching', await json('/videos/matching', {...call, query: wanted}), {videos: 'object', left: 'number', unreadable: 'number'}),
    /** @param {string} id @param {Call} [call] @returns {Promise<Video>} */
    video: async (id, call) => expectObject('GET /videos/…', await json(`/videos/${e(id)}`, call), VIDEO),
    /** @param {string} path @param {Call} [call] @returns {Promise<Video>} */
    addVideo: async (path, call) => expectObject('POST /videos', await json('/videos', {...call, method: 'POST', body: {path}, timeout: 60_000}), VIDEO),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    removeVideo: (id, call) => json(`/videos/${e(id)}`, {...call, method: 'DELETE'}),
    /**
     * @param {File} file
     * @param {{onProgress?: (sent: number, total: number) => void, signal?: AbortSignal}} [options]
     * @returns {Promise<Video>}
     */
    uploadVideo: async (file, options = {}) => expectObject('PUT /uploads/…', await upload(`${base}/uploads/${e(file.name)}`, file, options), VIDEO),
    /** @param {string} id @param {Call} [call] @returns {Promise<import('../types.js').FrameTableData>} */
    frameTable: async (id, call) => expectObject('GET /videos/…/table', await json(`/videos/${e(id)}/table`, call), {frames: 'number', time_base: 'array', steps: 'array', keys: 'array', corrupt: 'array'}),
    /** @param {string|null} path   null: where to begin @param {Call} [call] @returns {Promise<Folder>} */
    browse: async (path, call) => expectObject('GET /browse', await json('/browse', {...call, query: {path}}), {path: 'string', folders: 'array', videos: 'array', truncated: 'boolean'}),
    /** @param {string} id @returns {string} address of the picture */
    thumbnailUrl: (id) => `${base}/videos/${e(id)}/thumbnail`,
    /**
     * @param {string} id
     * @param {number} frame   ordinal
     * @param {{width?: number, format?: 'jpeg'|'webp'}} [options]
     * @returns {string} address of the picture
     */
    frameUrl: (id, frame, options) => `${base}/videos/${e(id)}/frames/${frame}${queryText(options)}`,
    /**
     * @param {string} id
     * @param {number} frame
     * @param {import('../types.js').Box} part   whole px, in the picture
     * @param {number} size                      longer side, px
     * @returns {string} address of a part of the picture
     */
    framePartUrl: (id, frame, [x1, y1, x2, y2], size) => `${base}/videos/${e(id)}/frames/${frame}/crop${queryText({x1, y1, x2, y2, size})}`,
    /**
     * The picture of a frame, with the ordinal that the server says it has. A preview may get a small, soft one, which
     * is not exact.
     *
     * @param {string} id
     * @param {number} frame
     * @param {{width?: number, format?: 'jpeg'|'webp', preview?: boolean, signal?: AbortSignal, timeout?: number}} [options]
     * @returns {Promise<{blob: Blob, ordinal: number, pts: number|null, exact: boolean}>}
     */
    frame: async (id, frame, {width, format, preview, ...call} = {}) => {
      const query = {width, format, preview: preview ? 'true' : undefined};
      const answer = await send(`/videos/${e(id)}/frames/${frame}`, {...call, query});
      const ordinal = answer.headers.get('X-Frame-Ordinal');
      const pts = answer.headers.get('X-Frame-Pts');
      expectObject('GET /videos/…/frames/…', {ordinal: ordinal === null ? null : Number(ordinal)}, {ordinal: 'number'});
      const exact = answer.headers.get('X-Frame-Exact') !== 'false';
      return {blob: await answer.blob(), ordinal: Number(ordinal), pts: pts === null ? null : Number(pts), exact};
    },

    // -- runs
    /** @param {string} video @param {Call} [call] @returns {Promise<Run[]>} */
    runs: async (video, call) => {
      const answer = expectObject('GET /videos/…/runs', await json(`/videos/${e(video)}/runs`, call), {runs: 'array'});
      return expectList('GET /videos/…/runs', answer.runs, RUN);
    },
    /** @param {string} video @param {RunRequest} request @param {Call} [call] @returns {Promise<Run>} */
    startRun: async (video, request, call) => expectObject('POST /videos/…/runs', await json(`/videos/${e(video)}/runs`, {...call, method: 'POST', body: request}), RUN),
    /** Runs of the engine that go on or wait, in the order of their turns. @param {Call} [call] @returns {Promise<Run[]>} */
    runQueue: async (call) => {
      const answer = expectObject('GET /run-queue', await json('/run-queue', call), {runs: 'array'});
      return expectList('GET /run-queue', answer.runs, RUN);
    },
    /** @param {string} id @param {string|null} before   null: after all that wait @param {Call} [call] @returns {Promise<Run>} */
    moveRun: async (id, before, call) => expectObject('POST /runs/…/turn', await json(`/runs/${e(id)}/turn`, {...call, method: 'POST', body: {before}}), RUN),
    /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
    run: async (id, call) => expectObject('GET /runs/…', await json(`/runs/${e(id)}`, call), RUN),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    removeRun: (id, call) => json(`/runs/${e(id)}`, {...call, method: 'DELETE'}),
    /** @param {string} id @param {string} name @param {Call} [call] @returns {Promise<Run>} */
    renameRun: async (id, name, call) => expectObject('PATCH /runs/…', await json(`/runs/${e(id)}`, {...call, method: 'PATCH', body: {name}}), RUN),
    /** @param {string} id @param {Call} [call] @returns {Promise<string[]>} those that are gone */
    removeWhatIfs: async (id, call) => expectObject('DELETE /runs/…/whatifs', await json(`/runs/${e(id)}/whatifs`, {...call, method: 'DELETE'}), {removed: 'array'}).removed,
    /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
    cancelRun: async (id, call) => expectObject('POST /runs/…/cancel', await json(`/runs/${e(id)}/cancel`, {...call, method: 'POST'}), RUN),
    /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
    resumeRun: async (id, call) => expectObject('POST /runs/…/resume', await json(`/runs/${e(id)}/resume`, {...call, method: 'POST'}), RUN),
    /** @param {string} id @param {{parameters: Record<string, unknown>, name?: string}} request @param {Call} [call] @returns {Promise<Run>} */
    whatIf: async (id, request, call) => expectObject('POST /runs/…/whatif', await json(`/runs/${e(id)}/whatif`, {...call, method: 'POST', body: request}), RUN),

    // -- evidence
    /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').TrackColumns>} */
    tracks: async (run, call) => expectColumns('GET /runs/…/tracks', await json(`/runs/${e(run)}/tracks`, {timeout: 60_000, ...call}), ['id', 'first', 'last', 'frames', 'detected', 'class_id', 'uncertainty', 'rank', 'reasons']),
    /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').LaneColumns>} */
    lanes: async (run, call) => expectColumns('GET /runs/…/lanes', await json(`/runs/${e(run)}/lanes`, {timeout: 60_000, ...call}), ['track', 'first', 'last', 'source']),
    /** @param {string} run @param {number} first @param {number} last   inclusive; <= 256 frames @param {Call} [call] @returns {Promise<import('../types.js').Overlay[]>} */
    overlays: async (run, first, last, call) => {
      const answer = expectObject('GET /runs/…/overlays', await json(`/runs/${e(run)}/overlays`, {...call, query: {first, last}}), {overlays: 'array'});
      return expectList('GET /runs/…/overlays', answer.overlays, {frame: 'number', detections: 'array', tracks: 'array'});
    },
    /** @param {string} run @param {number} track @param {Call} [call] @returns {Promise<import('../types.js').TrackLane>} */
    track: async (run, track, call) => expectColumns('GET /runs/…/tracks/…', await json(`/runs/${e(run)}/tracks/${track}`, call), ['frame', 'source', 'box', 'score', 'l_positive']),
    /** @param {string} run @param {number} track @param {number} frame @param {number} [size]   longest side, px @returns {string} */
    cropUrl: (run, track, frame, size) => `${base}/runs/${e(run)}/tracks/${track}/crops/${frame}${queryText({size})}`,
    /** @param {string} run @param {number} tau @param {Call} [call] @returns {Promise<import('../types.js').Flips>} */
    flips: async (run, tau, call) => expectObject('GET /runs/…/flips', await json(`/runs/${e(run)}/flips`, {...call, query: {tau}}), {verdicts: 'number', to_confident: 'number', to_rejected: 'number', tracks: 'array'}),
    /** @param {string} run @param {number} track @param {number} frame @param {Call} [call] @returns {Promise<Explanation>} */
    explain: async (run, track, frame, call) => expectObject('GET /runs/…/explain', await json(`/runs/${e(run)}/tracks/${track}/explain/${frame}`, call), {symmetry: 'nullable', hash: 'nullable', tau: 'number'}),

    // -- truth and comparison
    /** @param {string} video @param {Call} [call] @returns {Promise<GroundTruth[]>} */
    groundTruths: async (video, call) => {
      const answer = expectObject('GET /videos/…/ground-truths', await json(`/videos/${e(video)}/ground-truths`, call), {ground_truths: 'array'});
      return expectList('GET /videos/…/ground-truths', answer.ground_truths, {id: 'string', name: 'string', count: 'number'});
    },
    /** @param {string} video @param {string} name @param {Blob|string} csv @param {Call} [call] @returns {Promise<GroundTruth>} */
    putTruth: async (video, name, csv, call) => expectObject('PUT /videos/…/ground-truths/…', await json(`/videos/${e(video)}/ground-truths/${e(name)}`, {...call, method: 'PUT', body: csv, type: 'text/csv'}), {id: 'string', count: 'number'}),
    /** @param {string} truth @param {number} first @param {number} last @param {Call} [call] @returns {Promise<GroundTruthBox[]>} */
    truthBoxes: async (truth, first, last, call) => {
      const answer = await json(`/ground-truths/${e(truth)}/boxes`, {...call, query: {first, last}});
      return expectList('GET /ground-truths/…/boxes', Array.isArray(answer) ? answer : answer?.boxes, {frame: 'number', box: 'array', class_id: 'nullable'});
    },
    /** @param {string} truth @param {Call} [call] @returns {Promise<void>} */
    removeTruth: (truth, call) => json(`/ground-truths/${e(truth)}`, {...call, method: 'DELETE'}),
    /**
     * Correct a run by signs of a ground truth, all in one operation.
     * @param {string} run
     * @param {{truth: string, signs?: number[], label?: number, author?: string|null}} wanted
     * @param {Call} [call]
     * @returns {Promise<import('./compare-types.js').TakenOver>}
     */
    takeOver: async (run, wanted, call) => expectObject('POST /runs/…/take-over', await json(`/runs/${e(run)}/take-over`, {...call, method: 'POST', body: wanted, timeout: 120_000}), {changed: 'number', made: 'number', same: 'number', op_id: 'nullable', skipped: 'array'}),
    /** @param {string} reference   `run:ID`, `annotation:RUN` or `truth:ID` @param {string} candidate @param {Call} [call] @returns {Promise<Comparison>} */
    compare: async (reference, candidate, call) => expectObject('GET /compare', await json('/compare', {timeout: 120_000, ...call, query: {reference, candidate}}), {figures: 'object', confusion: 'object'}),

    // -- files that are made from runs
    /** @param {{kind?: string, run?: string}} [query] @param {Call} [call] @returns {Promise<import('../types.js').Output[]>} */
    outputs: async (query = {}, call) => {
      const answer = expectObject('GET /outputs', await json('/outputs', {...call, query}), {outputs: 'array'});
      return expectList('GET /outputs', answer.outputs, OUTPUT);
    },
    /** @param {string} id @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    output: async (id, call) => expectObject('GET /outputs/…', await json(`/outputs/${e(id)}`, call), OUTPUT),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    removeOutput: (id, call) => json(`/outputs/${e(id)}`, {...call, method: 'DELETE'}),
    /** @param {string} id @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    cancelOutput: async (id, call) => expectObject('POST /outputs/…/cancel', await json(`/outputs/${e(id)}/cancel`, {...call, method: 'POST'}), OUTPUT),
    /** @param {string} id @returns {string} address of the file */
    downloadUrl: (id) => `${base}/outputs/${e(id)}/download`,
    /** @param {Call} [call] @returns {Promise<import('../types.js').Format[]>} */
    formats: async (call) => expectList('GET /formats', expectObject('GET /formats', await json('/formats', call), {formats: 'array'}).formats, {name: 'string', title: 'string', summary: 'string', export_switches: 'array', import_switches: 'array'}),
    /** @param {import('../types.js').ExportRequest} request @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    startExport: async (request, call) => expectObject('POST /exports', await json('/exports', {...call, method: 'POST', body: request}), OUTPUT),
    /** @param {string} run @param {{first: number, stop: number, frame?: number|null, track?: string|null, name?: string}} request @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    record: async (run, request, call) => expectObject('POST /runs/…/recordings', await json(`/runs/${e(run)}/recordings`, {...call, method: 'POST', body: request}), OUTPUT),
    /** @param {string} run @param {{first: number, stop: number, note: string, tracks?: string[]}} request @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    makeBundle: async (run, request, call) => expectObject('POST /runs/…/bundles', await json(`/runs/${e(run)}/bundles`, {...call, method: 'POST', body: request}), OUTPUT),
    /**
     * @param {File} file
     * @param {string|null} author
     * @param {Sending} [options]
     * @returns {Promise<{video: Video, run: Run, report: BundleReport}>}
     */
    importBundle: async (file, author, options = {}) => expectObject('POST /bundles', await upload(`${base}/bundles${queryText({author, name: file.name})}`, file, {...options, method: 'POST'}), {video: 'object', run: 'object', report: 'object'}),
    /**
     * Lay a file onto a video.
     *
     * @param {string} video
     * @param {File} file
     * @param {{as: 'annotation'|'truth'|'run', format?: string|null, run?: string|null, name?: string, switches?: string, label_map?: string, unknown?: 'refuse'|'add'|'skip', add?: string, author?: string|null, progress?: string}} query
     * @param {Sending} [options]
     * @returns {Promise<import('../types.js').ImportResult>}
     */
    importFile: async (video, file, query, options = {}) => expectObject('POST /videos/…/imports', await upload(`${base}/videos/${e(video)}/imports${queryText({file: file.name.slice(-255), ...query})}`, file, {...options, method: 'POST'}), {kind: 'string', id: 'string', tracks: 'number', boxes: 'number', repaired: 'array', skipped: 'array'}),
    /** What an import is doing now, by the name that `progress` gave it. @param {string} name @param {Call} [call] @returns {Promise<import('../types.js').ImportProgress>} */
    importProgress: async (name, call) => expectObject('GET /imports/…', await json(`/imports/${e(name)}`, call), {step: 'string', boxes: 'number', seconds: 'number'}),
    /** @param {string} name @param {Call} [call] */
    cancelImport: async (name, call) => void await json(`/imports/${e(name)}/cancel`, {...call, method: 'POST'}),

    // -- models
    /** @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion[]>} */
    models: async (call) => expectList('GET /models', expectObject('GET /models', await json('/models', call), {models: 'array'}).models, MODEL),
    /** @param {Call} [call] @returns {Promise<{reviews: import('../model/training_sources.js').ReviewSource[], exports: import('../model/training_sources.js').ExportAge[]}>} */
    trainingSources: async (call) => expectObject('GET /models/sources', await json('/models/sources', call), {reviews: 'array', exports: 'array'}),
    /** @param {import('../types.js').ModelRequest} request @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} */
    train: async (request, call) => expectObject('POST /models', await json('/models', {...call, method: 'POST', body: request}), MODEL),
    /** @param {string} id @param {'promote'|'cancel'|'resume'} what @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} */
    changeModel: async (id, what, call) => expectObject(`POST /models/…/${what}`, await json(`/models/${e(id)}/${what}`, {...call, method: 'POST'}), MODEL),
    /** @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} the one that is active now */
    rollBackModels: async (call) => expectObject('POST /models/rollback', await json('/models/rollback', {...call, method: 'POST'}), MODEL),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    removeModel: (id, call) => json(`/models/${e(id)}`, {...call, method: 'DELETE'}),

    // -- edits
    /** @param {string} run @param {string|null} [author] @param {Call} [call] @returns {Promise<import('../types.js').Annotation>} */
    annotation: async (run, author, call) => expectObject('GET /runs/…/annotation', await json(`/runs/${e(run)}/annotation`, {...call, query: {author}}), {seq: 'number', docs: 'array'}),
    /**
     * @param {string} run
     * @param {{op_id: string, author: string, command: Command|{name: 'undo'|'redo', op_id: string}}} edit
     * @param {Record<string, number>} revisions   of every track that the command touches
     * @param {Call} [call]
     * @returns {Promise<import('../types.js').EditAnswer>}
     */
    edit: async (run, edit, revisions, call) => {
      const match = Object.entries(revisions).map(([key, revision]) => `"${key}:${revision}"`).join(', ');
      const answer = await json(`/runs/${e(run)}/edits`, {...call, method: 'POST', body: edit, headers: match ? {'If-Match': match} : {}});
      return expectObject('POST /runs/…/edits', answer, {op_id: 'string', seq: 'number', docs: 'array'});
    },
    /** @param {string} video @param {string|null} author @param {Call} [call] @returns {Promise<Run>} a run without an engine, for whoever draws all tracks */
    startByHand: async (video, author, call) => expectObject('POST /videos/…/runs/by-hand', await json(`/videos/${e(video)}/runs/by-hand`, {...call, method: 'POST', body: {author}}), RUN),
    /** @param {string} run @param {{key: string, anchors: import('../types.js').FollowAnchor[], only: string|null, first: number, last: number|null, author: string|null}} wanted @param {Call} [call] @returns {Promise<import('../types.js').Follow>} */
    startFollow: async (run, wanted, call) => expectObject('POST /runs/…/follows', await json(`/runs/${e(run)}/follows`, {...call, method: 'POST', body: wanted}), FOLLOW),
    /** @param {string} run @param {string|null} author @param {Call} [call] @returns {Promise<import('../types.js').Follow|null>} */
    findFollow: async (run, author, call) => expectObject('GET /runs/…/follows', await json(`/runs/${e(run)}/follows`, {...call, query: {author}}), {found: 'nullable'}).found,
    /** @param {string} id @param {number} after @param {number} wait   seconds @param {Call} [call] @returns {Promise<import('../types.js').Follow>} */
    follow: async (id, after, wait, call) => expectObject('GET /follows/…', await json(`/follows/${e(id)}`, {...call, query: {after, wait}}), FOLLOW),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    dropFollow: (id, call) => json(`/follows/${e(id)}`, {...call, method: 'DELETE'}),
    /** @param {string} run @param {number} after @param {Call} [call] @returns {Promise<{edits: import('../model/deleted.js').LogRow[]}>} at most a thousand rows of the log after a number */
    edits: async (run, after, call) => expectObject('GET /runs/…/edits', await json(`/runs/${e(run)}/edits`, {...call, query: {after}}), {edits: 'array'}),
    /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').Earlier|null>} */
    earlier: async (run, call) => expectObject('GET /runs/…/earlier', await json(`/runs/${e(run)}/earlier`, call), {found: 'nullable'}).found,
    /** @param {string} run @param {string} from @param {string|null} author @param {Call} [call] @returns {Promise<Adoption>} */
    adopt: async (run, from, author, call) => expectObject('POST /runs/…/adopt', await json(`/runs/${e(run)}/adopt`, {...call, method: 'POST', body: {from_run: from, author}, timeout: 120_000}), {kept: 'array', not_needed: 'array', conflicts: 'array'}),
  };
}

// @ts-check
/**
 * Actions on everything except the review of one run: catalogue, videos, runs, route, banners, dialog, theme. Pure.
 *
 * @typedef {import('../../state-types.js').State} State
 * @typedef {import('../../types.js').Video} Video
 * @typedef {import('../../types.js').Run} Run
 * @typedef {import('../../state-types.js').Banner} Banner
 */

/** @param {State} state @param {import('../../types.js').Session} session @returns {State} */
export const setSession = (state, session) => ({ ...state, session });

/** @param {State} state @param {import('../../types.js').Label[]} labels @returns {State} */
export const setLabels = (state, labels) => ({ ...state, labels });

/** @param {State} state @param {import('../../types.js').LabelSetSummary[]} labelSets @returns {State} */
export const setLabelSets = (state, labelSets) => ({ ...state, labelSets });

/** @param {State} state @param {import('../../types.js').Parameter[]} parameters @returns {State} */
export const setParameters = (state, parameters) => ({ ...state, parameters });

/** @param {State} state @param {import('../../state-types.js').Route} route @returns {State} */
export const setRoute = (state, route) => ({ ...state, route });

/** @param {State} state @param {Video[]} videos @returns {State} */
export const setVideos = (state, videos) => ({ ...state, videos });

/** Add or replace a video; newest first. @param {State} state @param {Video} video @returns {State} */
export function putVideo(state, video) {
  const review = state.review?.video.id === video.id ? { ...state.review, video } : state.review;
  return { ...state, videos: state.videos && withItem(state.videos, video), review };
}

/** Also drops the assignments of the video, as the server does. @param {State} state @param {string} id @returns {State} */
export function dropVideo(state, id) {
  const { [id]: _, ...runs } = state.runs;
  const assignments = state.assignments.filter(({ video_id }) => video_id !== id);
  return { ...state, videos: withoutItem(state.videos, id), runs, assignments };
}

/** @param {State} state @param {string} video @param {Run[]} runs @returns {State} */
export const setRuns = (state, video, runs) => ({ ...state, runs: { ...state.runs, [video]: runs } });

/**
 * Add or replace a run. Does nothing if the runs of its video are not loaded yet.
 * @param {State} state
 * @param {Run} run
 * @returns {State}
 */
export function putRun(state, run) {
  const review = state.review?.run?.id === run.id ? { ...state.review, run } : state.review;
  const runs = state.runs[run.video_id];
  if (!runs) return review === state.review ? state : { ...state, review };
  return { ...state, runs: { ...state.runs, [run.video_id]: withItem(runs, run) }, review };
}

/** @param {State} state @param {string} id @returns {State} */
export function dropRun(state, id) {
  const entries = Object.entries(state.runs).map(([video, runs]) => [video, runs.filter((run) => run.id !== id)]);
  return { ...state, runs: Object.fromEntries(entries) };
}

/** @param {State} state @param {import('../../state-types.js').Dialog} dialog @returns {State} */
export const openDialog = (state, dialog) => ({ ...state, dialog });

/** @param {State} state @returns {State} */
export const closeDialog = (state) => (state.dialog === null ? state : { ...state, dialog: null });

/** @param {State} state @param {'light'|'dark'|'auto'} theme @returns {State} */
export const setTheme = (state, theme) => ({ ...state, theme });

/** Change how the lanes are shown. @param {State} state @param {Partial<State['lanesView']>} change @returns {State} */
export const changeLanesView = (state, change) => ({ ...state, lanesView: { ...state.lanesView, ...change } });

/** @param {State} state @param {'online'|'offline'} connection @returns {State} */
export const setConnection = (state, connection) => (state.connection === connection ? state : { ...state, connection });

/** Set the unsaved edits of runs that are not open. @param {State} state @param {State['elsewhere']} elsewhere @returns {State} */
export const setElsewhere = (state, elsewhere) => (state.elsewhere.length + elsewhere.length === 0 ? state : { ...state, elsewhere });

/** Show a banner, or replace the one with the same id. @param {State} state @param {Banner} banner @returns {State} */
export function showBanner(state, banner) {
  const shown = state.banners.some(({ id }) => id === banner.id);
  const banners = shown ? state.banners.map((one) => (one.id === banner.id ? banner : one)) : [...state.banners, banner];
  return { ...state, banners };
}

/** @param {State} state @param {string} id @returns {State} */
export function hideBanner(state, id) {
  const banners = withoutItem(state.banners, id);
  return banners === state.banners ? state : { ...state, banners };
}

/** @param {State} state @param {import('../../types.js').Output[]} outputs @returns {State} */
export const setOutputs = (state, outputs) => ({ ...state, outputs });

/**
 * Add or replace a file; newest first.
 * @param {State} state
 * @param {import('../../types.js').Output} output
 * @returns {State}
 */
export const putOutput = (state, output) => (state.outputs === null ? state : { ...state, outputs: withItem(state.outputs, output) });

/** @param {State} state @param {import('../../types.js').ModelVersion[]} models @returns {State} */
export const setModels = (state, models) => ({ ...state, models });

/**
 * Add or replace a model version. At most one is active; without one, the shipped version is.
 * @param {State} state
 * @param {import('../../types.js').ModelVersion} version
 * @returns {State}
 */
export function putModel(state, version) {
  if (state.models === null) return state;
  const models = withItem(state.models, version);
  const active = version.active ? version.id : (models.find((other) => other.active && other.id !== 'shipped')?.id ?? 'shipped');
  return {
    ...state,
    models: models.map((other) => (other.active === (other.id === active) ? other : { ...other, active: other.id === active })),
  };
}

/** Remove a file or a version. @param {State} state @param {string} id @returns {State} */
export function dropOutputOrModel(state, id) {
  const outputs = withoutItem(state.outputs, id);
  const models = withoutItem(state.models, id);
  return outputs === state.outputs && models === state.models ? state : { ...state, outputs, models };
}

/**
 * The list with an item replaced, or put at its start.
 * @template {{id: string}} T
 * @param {T[]} list
 * @param {T} item
 * @returns {T[]}
 */
function withItem(list, item) {
  return list.some(({ id }) => id === item.id) ? list.map((other) => (other.id === item.id ? item : other)) : [item, ...list];
}

/**
 * The list without an item; the same object if it has none of that id.
 * @template {{id: string}} T
 * @template {T[]|null} L
 * @param {L} list
 * @param {string} id
 * @returns {L}
 */
function withoutItem(list, id) {
  return list?.some((item) => item.id === id) ? /** @type {L} */ (list.filter((item) => item.id !== id)) : list;
}

// @ts-check
/** The initial state. */

import { NO_FILTER } from '../model/queue.js';

/** @typedef {import('../state-types.js').State} State */
/** @typedef {import('../state-types.js').ReviewState} ReviewState */

/** The layers that a first visit shows, in the order of their keys: 1 to 9, then Shift+9. @type {ReviewState['layers']} */
export const DEFAULT_LAYERS = Object.freeze({
  detections: false,
  predictions: true,
  search: false,
  relocalisations: true,
  results: true,
  corrected: true,
  truth: false,
  second: true,
  uncertainty: false,
  gate: false,
});

export const LAYERS = /** @type {readonly import('../state-types.js').LayerName[]} */ (Object.keys(DEFAULT_LAYERS));

/** @returns {State} */
export const initialState = () => ({
  route: { screen: 'library' },
  session: null,
  labels: [],
  labelSets: null,
  parameters: [],
  videos: null,
  runs: {},
  outputs: null,
  models: null,
  assignments: [],
  review: null,
  banners: [],
  elsewhere: [],
  connection: 'online',
  theme: 'auto',
  layers: DEFAULT_LAYERS,
  fewLabels: false,
  lanesView: { folded: true, lane: 'gate' },
  dialog: null,
});

/**
 * @param {import('../types.js').Video} video
 * @param {ReviewState['layers']} [layers]   as the user left them
 * @param {boolean} [fewLabels]
 * @returns {ReviewState}
 */
export const initialReview = (video, layers = DEFAULT_LAYERS, fewLabels = false) => ({
  video,
  timebase: null,
  run: null,
  tracks: null,
  lanes: null,
  laneOf: {},
  overlays: {},
  secondOverlays: {},
  secondTracks: null,
  secondDocs: {},
  truth: {},
  truthId: null,
  truthSign: null,
  truthName: null,
  second: null,
  frame: 0,
  shown: null,
  playing: false,
  selected: null,
  layers,
  fewLabels,
  hovered: null,
  viewport: { zoom: 0, x: 0, y: 0 },
  span: { first: 0, last: Math.max(1, video.frames ?? 1) },
  tau: null,
  mode: 'select',
  marked: [],
  docs: {},
  seq: null,
  undo: null,
  redo: null,
  unsaved: [],
  drag: null,
  filter: { ...NO_FILTER },
  earlier: null,
  beside: null,
  following: null,
});

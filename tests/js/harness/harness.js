// @ts-check
/** The three views on synthetic state: `?frames=132400&tracks=5000`. For looking at and for measuring. */
import { createInspector } from '../../../static/js/views/inspector/index.js';
import { createLanes } from '../../../static/js/views/lanes/index.js';
import { createNoteDrafts } from '../../../static/js/editing/note_drafts.js';
import { createQueue } from '../../../static/js/views/queue/index.js';
import { keyFrame } from '../server_data.js';
import { syntheticRun, syntheticLane } from './synthetic_run.js';

const query = new URLSearchParams(location.search);
const frames = Number(query.get('frames') ?? 132400);
const count = Number(query.get('tracks') ?? 5000);
const made = syntheticRun(frames, count);
const picked = made.tracks.last.reduce(
  (/** @type {number} */ best, /** @type {number} */ _, /** @type {number} */ i) =>
    made.tracks.last[i] - made.tracks.first[i] > made.tracks.last[best] - made.tracks.first[best] ? i : best,
  0,
);
/** @param {string|number} text */
const sign = (text) =>
  `data:image/svg+xml,${encodeURIComponent(`<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><circle cx="16" cy="16" r="13" fill="#fff" stroke="#c00" stroke-width="5"/><text x="16" y="21" font-size="12" text-anchor="middle" font-family="sans-serif">${text}</text></svg>`)}`;
const lane = syntheticLane(made.tracks, picked, made.tracks.last[picked]);
const key = `m${lane.id}`;
let state = /** @type {any} */ ({
  labels: Array.from({ length: 43 }, (_, id) => ({
    id,
    name: ['Speed limit 50', 'No overtaking', 'Priority road', 'Yield', '<b>Stop</b>'][id % 5] + (id > 4 ? ` ${id}` : ''),
    picture: sign(id),
  })),
  review: {
    video: { frames, rate: 30, duration: frames / 30 },
    timebase: null,
    run: {
      id: 'r1',
      preset: 'default',
      engine_version: '0.1',
      created: '2026-11-21T06:00:00Z',
      parameters: { 'gate.tau': 15 },
      models: { classifier: 'a1b2c3d4e5f6' },
    },
    tracks: made.tracks,
    lanes: made.lanes,
    laneOf: { [lane.id]: lane },
    frame: lane.frame[80] ?? lane.frame[5],
    selected: key,
    tau: null,
    span: { first: 0, last: frames },
    filter: {
      class_id: null,
      review: 'all',
      least_uncertainty: 0,
      least_score: null,
      most_score: null,
      attribute: null,
      text: '',
      sort: 'uncertainty',
    },
    docs: {
      [key]: {
        key,
        revision: 1,
        class_id: null,
        review: 'needs_work',
        not_a_sign: false,
        segments: [{ track: lane.id, first: lane.frame[0], last: lane.frame.at(-1) }],
        keys: { [lane.frame[30]]: keyFrame({ box: [1, 1, 9, 9] }), [lane.frame[60]]: keyFrame({ box: [2, 2, 9, 9] }) },
        notes: [{ id: 'n1', frame: lane.frame[10], text: 'Half behind a <truck>', author: 'anna', time: '2026-11-21T06:10:00Z' }],
        gone: false,
        merged_into: null,
      },
    },
  },
});
let pending = 0;
/** @type {{element: HTMLElement, update: (state: any) => void}[]} */
const views = [];
/** @type {any[]} */
const edits = [];
/** @type {any} */
const app = {
  store: {
    get: () => state,
    dispatch: (/** @type {any} */ action, /** @type {any[]} */ ...rest) => {
      state = action(state, ...rest);
      pending ||= requestAnimationFrame(() => {
        pending = 0;
        for (const view of views) view.update(state);
      });
    },
  },
  api: {
    cropUrl: (/** @type {string} */ _, /** @type {number} */ __, /** @type {number} */ frame) => sign(frame % 100),
    explain: async () => ({
      symmetry: {
        axis: [32, 2, 32, 62],
        matches: [
          [12, 20, 52, 20, 1],
          [18, 40, 46, 41, 0.6],
          [10, 32, 54, 33, 0.3],
        ],
        magnitude: 0.42,
        size: [64, 64],
      },
      hash: { crop: 'f0e1d2c3b4a59687', mean: 'f0e1d0c3b5a59617', distance: 4 },
      l_positive: 12,
      tau: 15,
    }),
  },
  edit: (/** @type {any} */ command) => {
    edits.push(command);
    return true;
  },
  notes: createNoteDrafts(() => sessionStorage),
};
Reflect.set(globalThis, 'harness', { app, lane, frames, edits });
views.push(createQueue(app), createLanes(app), createInspector(app));
document.getElementById('app')?.append(...views.map((view) => view.element));
app.store.dispatch((/** @type {any} */ s) => ({ ...s }));

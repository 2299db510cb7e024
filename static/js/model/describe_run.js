// @ts-check
/** Names, states and progress of runs as text. Pure functions. */

import { runPercent } from './run_progress.js';
import { capitalized, count, figure, moment, plural, timeLeft } from './format.js';

/** @typedef {import('../types.js').Run} Run */

/** @type {Record<Run['state'], string>} */
const TONES = {
  queued: '',
  running: 'badge-accent',
  complete: 'badge-good',
  failed: 'badge-bad',
  cancelled: 'badge-warn',
  interrupted: 'badge-warn',
};

/** @param {Run} run @returns {string} one line for lists */
export function runTitle(run) {
  const state = run.state === 'running' ? runPercent(run) : run.state !== 'complete' ? runState(run) : runInexact(run) ? 'not exact' : '';
  return `${runName(run)}${state && ` (${state})`}`;
}

/** The name of a run, without its state. @param {Run} run @returns {string} `Run 1 · 21 Nov 2026, 06:20` */
export const runName = (run) => `${run.name || runKind(run)} · ${moment(run.created)}`;

/** The origin of its tracks. @param {Run} run @returns {string} `Preset default`, `What-if`, `Imported` */
export const runKind = ({ kind, preset }) => (kind === 'whatif' ? 'What-if' : kind === 'imported' ? 'Imported' : `Preset ${preset}`);

/** @param {Run} run @returns {string} */
export const runState = ({ state }) => (state === 'queued' ? 'waiting' : state);

/** @param {Run} run @returns {string} CSS class of a badge */
export const runTone = ({ state }) => TONES[state];

/** @param {Run} run @returns {string} its progress in words */
export function runProgress(run) {
  if (run.state === 'queued') return run.note ? `Waiting · ${run.note}` : 'Waiting for a free worker.';
  if (run.state === 'running') {
    const done = `${count(run.frames_done)} of ${run.frames_total === null ? 'the frames' : plural(run.frames_total, 'frame')}`;
    if (run.note) return `${done} · ${run.note}`;
    const speed = run.rate ? `${figure(run.rate)} fps` : 'starting';
    return [done, speed, timeLeft(run.remaining)].filter(Boolean).join(' · ');
  }
  if (run.state === 'complete')
    return [run.tracks === null ? '' : plural(run.tracks, 'track'), run.rate ? `processed at ${figure(run.rate)} fps` : '']
      .filter(Boolean)
      .join(' · ');
  if (run.state === 'failed') return run.error ?? 'The run failed without saying why; the terminal of the server has more.';
  return `${capitalized(run.state)} after ${plural(run.frames_done, 'frame')}. It can be resumed from there.`;
}

/** The pixels that a replay lacked: its results may differ from a run with these parameters. @param {Run} run @returns {string} empty: nothing */
export function runInexact({ summary }) {
  const { missing_pixels: pixels = 0, missing_frames: frames = 0 } = summary ?? {};
  if (!pixels) return '';
  return `Not exact: ${plural(pixels, 'pixel')} in ${plural(frames, 'frame')} ${pixels === 1 ? 'is' : 'are'} not in the evidence; the nearest stored ones were used instead. A new run with a larger keep_radius is exact.`;
}

/**
 * A warning about a parameter of a what-if, shown before the replay.
 *
 * @param {string} name
 * @param {unknown} value
 * @param {unknown} kept   keep_radius of the run, px
 * @returns {string} empty: no warning
 */
export function replayWarning(name, value, kept) {
  if (name !== 'search_radius' || typeof value !== 'number' || typeof kept !== 'number' || value <= kept) return '';
  return `The run has stored pixels up to ${count(kept)} px around each prediction (keep_radius). Farther out the nearest stored ones are used, so the result is not exact.`;
}

/** @param {Run} run @returns {string} `tau = 25, n = 3` */
export function runChanges(run) {
  return Object.entries(run.parameters)
    .map(([name, value]) => `${name} = ${Array.isArray(value) ? value.join(' ') : String(value)}`)
    .join(', ');
}

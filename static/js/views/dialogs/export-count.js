// @ts-check
/** How much would go out, while a person still chooses: from tracks and documents, without reading any box. */

import {countOut} from '../../model/exchange.js';
import {h, setText} from '../dom.js';
import {count, plural} from '../format.js';

/** @typedef {import('../../types.js').TrackColumns} TrackColumns */
/** @typedef {import('../../types.js').TrackDoc} TrackDoc */
/** @typedef {{tracks: TrackColumns, docs: TrackDoc[]}} Known */

/** More runs than this are not looked at. */
const MOST = 12;

/**
 * @param {import('../../page-types.js').App} app
 * @param {AbortSignal} signal
 */
export function createExportCount(app, signal) {
  const element = h('span', {class: 'muted small export-count', role: 'status'});
  /** @type {Map<string, Promise<Known>>} */
  const known = new Map();
  /** @type {import('../../types.js').ExportRequest|null} */
  let wanted = null;

  /** @param {string} run @returns {Promise<Known>} */
  function load(run) {
    const found = known.get(run) ?? Promise.all([app.api.tracks(run, {signal}), app.api.annotation(run, null, {signal})])
      .then(([tracks, {docs}]) => ({tracks, docs}));
    known.set(run, found);
    found.catch(() => known.delete(run));
    return found;
  }

  /** @param {import('../../types.js').ExportRequest|null} request   null: not complete yet */
  async function show(request) {
    wanted = request;
    if (request === null || request.runs.length > MOST) {
      setText(element, request === null ? '' : `${plural(request.runs.length, 'video')}`);
      return;
    }
    try {
      const runs = await Promise.all(request.runs.map(load));
      if (wanted !== request || signal.aborted) return;
      const rule = {states: request.states, classes: request.classes, first: request.first ?? 0, last: (request.stop ?? 2 ** 31 - 1) - 1};
      const sum = {tracks: 0, boxes: 0, rejected: 0};
      for (const {tracks, docs} of runs) {
        const out = countOut(tracks, docs, rule);
        sum.tracks += out.tracks;
        sum.boxes += out.boxes;
        sum.rejected += out.rejected;
      }
      const apart = sum.rejected ? `${plural(sum.rejected, 'rejected track')} apart` : '';
      const signs = sum.tracks ? `${plural(sum.tracks, 'track')}, ${request.min_side ? 'at most' : 'about'} ${count(sum.boxes)} boxes` : '';
      setText(element, [signs, apart].filter(Boolean).join('; ') || 'Nothing would go out: no track fits.');
    } catch {
      if (!signal.aborted && wanted === request) setText(element, '');
    }
  }

  return {element, show: (/** @type {import('../../types.js').ExportRequest|null} */ request) => void show(request)};
}

// @ts-check
/** A live estimate of what an export contains, from tracks and documents, without reading boxes. */

import { countExported } from '../../model/exchange.js';
import { resolveLabelId } from '../../model/labels.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';

/** @typedef {import('../../types.js').TrackColumns} TrackColumns */
/** @typedef {import('../../types.js').TrackDoc} TrackDoc */
/** @typedef {{tracks: TrackColumns, docs: TrackDoc[]}} Known */

/** Maximum number of runs for an estimate. */
const MOST = 12;

/**
 * @param {import('../../page-types.js').App} app
 * @param {AbortSignal} signal
 * @param {(byLabel: Map<number, number>|null) => void} tell   receives the exported tracks by label; null: not known
 */
export function createExportCount(app, signal, tell) {
  const element = h('span.muted.small.export-count', { role: 'status' });
  /** @type {Map<string, Promise<Known>>} */
  const known = new Map();
  /** @type {import('../../types.js').ExportRequest|null} */
  let wanted = null;

  /** @param {string} run @returns {Promise<Known>} */
  function load(run) {
    const found =
      known.get(run) ??
      Promise.all([app.api.tracks(run, { signal }), app.api.annotation(run, null, { signal })]).then(([tracks, { docs }]) => ({
        tracks,
        docs,
      }));
    known.set(run, found);
    found.catch(() => known.delete(run));
    return found;
  }

  /** @param {import('../../types.js').ExportRequest|null} request   null: not complete yet */
  async function show(request) {
    wanted = request;
    if (request === null || request.runs.length > MOST) {
      setText(element, request === null ? '' : `${plural(request.runs.length, 'video')}`);
      tell(null);
      return;
    }
    try {
      const runs = await Promise.all(request.runs.map(load));
      if (wanted !== request || signal.aborted) return;
      const { labels } = app.store.get();
      const picked = request.labels ? new Set(labels.filter(({ key }) => request.labels?.includes(key)).map(({ id }) => id)) : null;
      const rule = {
        states: request.states ?? [],
        labels: picked,
        notInSet: request.not_in_set ?? 'leave-out',
        first: request.first ?? 0,
        last: (request.stop ?? 2 ** 31 - 1) - 1,
      };
      const sum = { tracks: 0, boxes: 0, rejected: 0, open: 0, unlabelled: 0 };
      /** @type {Map<number, number>} */
      const byLabel = new Map();
      for (const { tracks, docs } of runs) {
        const out = countExported(tracks, docs, rule, (id) => resolveLabelId(labels, id));
        sum.tracks += out.tracks;
        sum.boxes += out.boxes;
        sum.rejected += out.rejected;
        sum.open += out.open;
        sum.unlabelled += out.unlabelled;
        for (const [id, found] of out.byLabel) byLabel.set(id, (byLabel.get(id) ?? 0) + found);
      }
      const apart = sum.rejected ? `${plural(sum.rejected, 'false positive')} separately` : '';
      const signs = sum.tracks
        ? `${plural(sum.tracks, 'track')}, ${request.min_side ? 'at most' : 'about'} ${plural(sum.boxes, 'box', 'boxes')}`
        : '';
      const behind = [
        sum.open ? `${plural(sum.open, 'open track')} ${sum.open === 1 ? 'is' : 'are'} left out` : '',
        sum.unlabelled ? `${count(sum.unlabelled)} not in the set` : '',
      ];
      setText(
        element,
        [[signs, apart].filter(Boolean).join('; ') || 'Nothing would be exported: no track matches', ...behind].filter(Boolean).join('; '),
      );
      tell(byLabel);
    } catch {
      if (!signal.aborted && wanted === request) setText(element, '');
    }
  }

  return { element, show: (/** @type {import('../../types.js').ExportRequest|null} */ request) => void show(request) };
}

// @ts-check
/** A live estimate of what an export contains, from tracks and documents, without reading boxes. */

import { countExported } from '../../model/exchange.js';
import { resolveLabelId } from '../../model/labels.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';

/** @typedef {import('../../types.js').TrackColumns} TrackColumns */
/** @typedef {import('../../types.js').TrackDoc} TrackDoc */
/** @typedef {{tracks: TrackColumns, docs: TrackDoc[]}} RunTracks */

/** Maximum number of runs for an estimate. */
const MAX_RUNS = 12;

/**
 * @param {import('../../page-types.js').App} app
 * @param {AbortSignal} signal
 * @param {(byLabel: Map<number, number>|null) => void} onCounted   receives the exported tracks by label; null: not known
 */
export function createExportEstimate(app, signal, onCounted) {
  const element = h('span.muted.small.export-count', { role: 'status' });
  /** @type {Map<string, Promise<RunTracks>>} */ const loadedRuns = new Map();
  /** @type {import('../../types.js').ExportRequest|null} */ let currentRequest = null;

  /** @param {string} run @returns {Promise<RunTracks>} */
  function load(run) {
    const loaded =
      loadedRuns.get(run) ??
      Promise.all([app.api.tracks(run, { signal }), app.api.annotation(run, null, { signal })]).then(([tracks, { docs }]) => ({
        tracks,
        docs,
      }));
    loadedRuns.set(run, loaded);
    loaded.catch(() => loadedRuns.delete(run));
    return loaded;
  }

  /** @param {import('../../types.js').ExportRequest|null} request   null: not complete yet */
  async function show(request) {
    currentRequest = request;
    if (request === null || request.runs.length > MAX_RUNS) {
      setText(element, request === null ? '' : `${plural(request.runs.length, 'video')}`);
      onCounted(null);
      return;
    }
    try {
      const runs = await Promise.all(request.runs.map(load));
      if (currentRequest !== request || signal.aborted) return;
      const { labels } = app.store.get();
      const labelIds = request.labels ? new Set(labels.filter(({ key }) => request.labels?.includes(key)).map(({ id }) => id)) : null;
      const criteria = {
        states: request.states ?? [],
        labels: labelIds,
        notInSet: request.not_in_set ?? 'leave-out',
        first: request.first ?? 0,
        last: (request.stop ?? 2 ** 31 - 1) - 1,
      };
      const totals = { tracks: 0, boxes: 0, rejected: 0, open: 0, unlabelled: 0 };
      /** @type {Map<number, number>} */ const byLabel = new Map();
      for (const { tracks, docs } of runs) {
        const counts = countExported(tracks, docs, criteria, (id) => resolveLabelId(labels, id));
        totals.tracks += counts.tracks;
        totals.boxes += counts.boxes;
        totals.rejected += counts.rejected;
        totals.open += counts.open;
        totals.unlabelled += counts.unlabelled;
        for (const [id, found] of counts.byLabel) byLabel.set(id, (byLabel.get(id) ?? 0) + found);
      }
      const falsePositivesText = totals.rejected ? `${plural(totals.rejected, 'false positive')} separately` : '';
      const tracksText = totals.tracks
        ? `${plural(totals.tracks, 'track')}, ${request.min_side ? 'at most' : 'about'} ${plural(totals.boxes, 'box', 'boxes')}`
        : '';
      const omittedTexts = [
        totals.open ? `${plural(totals.open, 'open track')} ${totals.open === 1 ? 'is' : 'are'} left out` : '',
        totals.unlabelled ? `${count(totals.unlabelled)} not in the set` : '',
      ];
      setText(
        element,
        [[tracksText, falsePositivesText].filter(Boolean).join('; ') || 'Nothing would be exported: no track matches', ...omittedTexts]
          .filter(Boolean)
          .join('; '),
      );
      onCounted(byLabel);
    } catch {
      if (!signal.aborted && currentRequest === request) setText(element, '');
    }
  }

  return { element, show: (/** @type {import('../../types.js').ExportRequest|null} */ request) => void show(request) };
}

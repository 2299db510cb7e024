// @ts-check
/**
 * The current frame of the track: origin of its box, verdict of the gate, class that was read, events. On demand, for
 * its crop: mirrored features with their axis, and the two perceptual hashes.
 */

import { lastIndexAt } from '../../model/detail_columns.js';
import { hashBits } from '../../model/hash_bits.js';
import { engineName } from '../../model/labels.js';
import { describeCorrectionAt } from '../../model/describe_corrections.js';
import { countsAs, shortNumber, describeSource, describeSymmetry, describeVerdict } from '../../model/describe_events.js';
import { fill, h, s, setText } from '../dom.js';
import { percent } from '../../model/format.js';

/** @typedef {{axis: [number, number, number, number]|null, matches: [number, number, number, number, number][], magnitude: number, size: [number, number]}} SymmetryView */

/** @param {import('../../page-types.js').ViewApp} app @param {AbortSignal} signal */
export function createExplain(app, signal) {
  const button = h('button.btn.btn-small', 'Explain this crop');
  const title = h('h3.grow');
  const infoElement = h('div.small.frame-facts');
  const result = h('div.explain', { 'aria-live': 'polite' });
  /** @type {import('./index.js').Inspected|null} */ let current = null;
  let requestedKey = '';
  let frames = new Int32Array(0);
  let shownText = '';
  button.addEventListener('click', async () => {
    const run = current?.review.run;
    if (!current?.laneData || !run) return;
    const frame = current.review.frame;
    const track = current.laneData.track[lastIndexAt(frames, frame)];
    const floor = current.laneData.lane.symmetry_floor;
    const key = `${run.id} ${current.entry.key} ${frame}`;
    requestedKey = key;
    fill(result, h('p.small.muted', 'Analysing the crop…'));
    try {
      const found = await app.api.explain(run.id, track, frame, { signal });
      if (requestedKey !== key) return;
      const url = app.api.cropUrl(run.id, track, frame, 256);
      const prediction = `${url}${url.includes('?') ? '&' : '?'}of=prediction`;
      const symmetry = /** @type {SymmetryView|null} */ (/** @type {unknown} */ (found.symmetry));
      fill(result, symmetry ? symmetryFigure(symmetry, prediction, floor) : null, found.hash ? hashFigure(found.hash) : null);
    } catch (error) {
      if (requestedKey === key && !signal.aborted)
        fill(result, h('p.small.field-error', error instanceof Error ? error.message : 'The crop could not be explained.'));
    }
  });
  return {
    element: h('div.inspector-section', h('div.row', title, button), infoElement, result),
    /** @param {import('./index.js').Inspected} inspected */
    update(inspected) {
      const { lane, review } = inspected;
      if (lane !== current?.lane) frames = Int32Array.from(lane?.frame ?? []);
      current = inspected;
      const key = lane && review.run ? `${review.run.id} ${inspected.entry.key} ${review.frame}` : '';
      if (requestedKey !== key && requestedKey !== '') {
        requestedKey = '';
        result.replaceChildren();
      }
      const at = lastIndexAt(frames, review.frame);
      const hasBox = lane && at >= 0 && lane.frame[at] === review.frame;
      const verdict = hasBox ? describeVerdict(lane, at) : null;
      button.hidden = verdict === null;
      setText(title, `Frame ${review.frame}`);
      const personText = inspected.doc && describeCorrectionAt(inspected.doc, review.frame);
      const engineLines = hasBox
        ? [
            describeSource(lane, at),
            verdict ?? 'The gate gave no verdict in this frame.',
            verdict && describeSymmetry(lane, at),
            readAs(inspected, at),
          ]
        : [inspected.isLoaded ? 'The track has no box of the engine in this frame.' : 'The values of the engine are loading…'];
      const lines = personText === null ? engineLines : [personText, hasBox ? 'The engine’s result here:' : null, ...engineLines];
      // events that the verdict already mentions are not repeated
      const events = inspected.sentences.filter(
        ({ frame, kind }) => frame === review.frame && !(hasBox && (kind === 'rejected' || kind === 'born' || kind === 'ended')),
      );
      const all = [...lines, ...events.map(({ text }) => `${text.charAt(0).toUpperCase()}${text.slice(1)}.`)].filter(
        (line) => line !== null,
      );
      if (all.join('\n') === shownText) return;
      shownText = all.join('\n');
      fill(infoElement, ...all.map((line) => h('p', line)));
    },
  };
}

/** The class that the classifier read in a frame, which may differ from the fused label. @param {import('./index.js').Inspected} inspected @param {number} i @returns {string|null} */
function readAs({ state, lane }, i) {
  const top = lane?.top[i] ?? null;
  if (!lane || top === null) return null;
  const weight = lane.weight[i] === null ? 'it has no vote' : `its vote weighs ${shortNumber(lane.weight[i])}`;
  return `Read as ${engineName(state.labels, top, lane.top_word?.[i])} with P = ${percent(lane.top_probability[i])}; ${weight}.`;
}

/** @param {SymmetryView} symmetry @param {string} url @param {number} floor   the run's symmetry_floor */
function symmetryFigure(symmetry, url, floor) {
  const [width, height] = symmetry.size;
  const strongest = Math.max(1e-9, ...symmetry.matches.map((match) => match[4]));
  const drawing = s(
    'svg.explain-matches',
    {
      viewBox: `0 0 ${width} ${height}`,
      role: 'img',
      'aria-label': `${symmetry.matches.length} mirrored pairs of features`,
    },
    s('image', { href: url, width, height, preserveAspectRatio: 'none' }),
    symmetry.matches.map(([x1, y1, x2, y2, weight]) =>
      s(
        'g',
        { opacity: (0.35 + (0.65 * weight) / strongest).toFixed(2) },
        s('line.explain-pair', { x1, y1, x2, y2 }),
        s('circle.explain-point', { cx: x1, cy: y1, r: width / 60 }),
        s('circle.explain-point', { cx: x2, cy: y2, r: width / 60 }),
      ),
    ),
    symmetry.axis
      ? s('line.explain-axis', { x1: symmetry.axis[0], y1: symmetry.axis[1], x2: symmetry.axis[2], y2: symmetry.axis[3] })
      : null,
  );
  return h(
    'figure',
    drawing,
    h(
      'figcaption.small.muted',
      `Symmetry from ${symmetry.matches.length} mirrored ${symmetry.matches.length === 1 ? 'pair' : 'pairs'}: ${shortNumber(symmetry.magnitude)}${countsAs(symmetry.magnitude, floor)}`,
    ),
  );
}

/** @param {{crop: string, mean: string, distance: number}} hash */
function hashFigure(hash) {
  const crop = hashBits(hash.crop);
  const mean = hashBits(hash.mean);
  /** @param {Uint8Array} bits @param {string} name */
  const grid = (bits, name) =>
    h(
      'figure.explain-hash',
      s(
        'svg',
        { viewBox: '0 0 8 8', role: 'img', 'aria-label': `Hash of the ${name}` },
        [...bits].map((bit, i) =>
          s('rect', {
            x: (i % 8) + 0.04,
            y: Math.floor(i / 8) + 0.04,
            width: 0.92,
            height: 0.92,
            class: bit ? 'explain-one' : 'explain-zero',
          }),
        ),
        [...bits].map((bit, i) =>
          crop[i] !== mean[i]
            ? s('rect.explain-differs', { x: (i % 8) + 0.12, y: Math.floor(i / 8) + 0.12, width: 0.76, height: 0.76 })
            : null,
        ),
      ),
      h('figcaption.small.muted', name),
    );
  return h(
    'figure',
    h('div.explain-hashes', grid(crop, 'crop'), grid(mean, 'mean of earlier crops')),
    h('figcaption.small.muted', `${shortNumber(hash.distance)} of 64 bits differ (framed)`),
  );
}

// @ts-check
/**
 * Draws the layers of one frame over the picture. Each layer has its own colour, dash and mark over a dark casing, so
 * that it is distinguishable without colour and on any background.
 *
 * @typedef {import('../../state-types.js').ReviewState} ReviewState
 * @typedef {import('../../state-types.js').LayerName} LayerName
 * @typedef {import('../../model/geometry.js').Viewport} Viewport
 * @typedef {import('../../model/geometry.js').Size} Size
 */
import { modeOf } from '../../modes/index.js';
import { chosenTruth } from '../../review/chosen_truth.js';
import { focusPoint } from '../../model/focus.js';
import { trackName } from '../../model/track_name.js';
import { secondRunSigns, shownTracks } from '../../review/shown_tracks.js';
import { LAYERS } from '../../store/initial.js';
import { createPen } from './pen.js';

/**
 * @param {CanvasRenderingContext2D} ctx   in CSS px
 * @param {ReviewState} review
 * @param {Viewport} view
 * @param {Size} screen
 * @param {import('./pen.js').PenStyle} style
 * @param {(id: number|null) => string} nameOf
 * @returns {Record<LayerName, number>} number of boxes of each layer in the frame
 */
export function paintLayers(ctx, review, view, screen, style, nameOf) {
  const counts = /** @type {Record<LayerName, number>} */ (Object.fromEntries(LAYERS.map((name) => [name, 0])));
  const pen = createPen(ctx, view, screen, style);
  const overlay = review.overlays[review.frame];
  const layersOn = review.layers;
  const focus = focusPoint(review.run, review.video);
  /** The text at a box. While few labels are shown, only the selected track and the one under the pointer have one. @param {string|null} key @param {string} text */
  const labelFor = (key, text) => (!review.fewLabels || (key !== null && (key === review.selected || key === review.hovered)) ? text : '');

  for (const { key, box, class_id } of secondRunSigns(review)) {
    counts.second++;
    if (layersOn.second)
      pen.box('second', box, labelFor(null, `${trackName(key, review.secondDocs[key])} ${pen.truncate(nameOf(class_id))}`));
  }
  for (const track of overlay?.tracks ?? []) {
    if (track.prediction) {
      counts.predictions++;
      counts.uncertainty++;
      if (layersOn.predictions && (track.source !== 0 || review.selected === `m${track.id}` || track.gate?.confident === false)) {
        pen.box('predictions', track.prediction.box);
        if (focus && track.source !== 0 && review.selected === `m${track.id}`) pen.ray(focus, track.prediction.box);
      }
    }
    if (track.gate) counts.gate++;
    if (track.relocalisation) {
      counts.search++;
      counts.relocalisations++;
      if (layersOn.relocalisations) {
        pen.box('relocalisations', track.relocalisation.box, labelFor(`m${track.id}`, `f ${track.relocalisation.decision.toFixed(2)}`));
        pen.cross('relocalisations', track.relocalisation.runner_up);
      }
    }
  }
  const tracks = shownTracks(review);
  for (const shown of tracks) {
    const layer = shown.edited ? 'corrected' : 'results';
    counts[layer]++;
    if (layersOn[layer] && shown.key !== review.selected) paintTrack(shown, layer);
  }
  const selected = tracks.find(({ key }) => key === review.selected);
  // the user judges the sign in the selected box: only requested layers cover it
  if (selected) pen.clear(selected.box);
  for (const { box, score, raw, track } of overlay?.detections ?? []) {
    counts.detections++;
    if (layersOn.detections)
      pen.box('detections', box, labelFor(track === null ? null : `m${track}`, `${raw.toFixed(1)} → ${score.toFixed(1)}`));
  }
  const chosenSign = chosenTruth(review);
  for (const { box, class_id, track } of review.truth[review.frame] ?? []) {
    counts.truth++;
    if (layersOn.truth) pen.box('truth', box, labelFor(null, pen.truncate(nameOf(class_id))));
    if (layersOn.truth && chosenSign?.sign === track) pen.corners('truth', box);
  }
  for (const { relocalisation, prediction } of overlay?.tracks ?? []) {
    if (layersOn.search && relocalisation) pen.box('search', relocalisation.search);
    if (layersOn.uncertainty && prediction) pen.innovation(prediction.box, prediction.sigma);
  }
  if (selected && layersOn[selected.edited ? 'corrected' : 'results']) paintTrack(selected, selected.edited ? 'corrected' : 'results');
  if (review.drag) {
    pen.box(
      'corrected',
      review.drag.box,
      `${(review.drag.box[2] - review.drag.box[0]).toFixed(0)} × ${(review.drag.box[3] - review.drag.box[1]).toFixed(0)}`,
      { where: 'above', weight: 3 },
    );
    pen.handles('corrected', review.drag.box);
  }

  /** @param {import('../../review/shown_tracks.js').ShownTrack} shown @param {LayerName} layer */
  function paintTrack(shown, layer) {
    if (review.drag?.key === shown.key) return;
    const { box } = shown;
    const isSelected = review.selected === shown.key;
    const gate = layersOn.gate ? shown.engine?.gate : null;
    const gateText = gate ? ` gate ${gate.l_positive < 100 ? gate.l_positive.toFixed(1) : Math.round(gate.l_positive)}` : '';
    const isProposed = shown.origin === 'proposed';
    const confidenceText = isProposed
      ? ` proposed ${Math.round(100 * (review.following?.proposals[review.frame]?.confidence ?? 0))} %`
      : '';
    pen.box(
      layer,
      box,
      labelFor(
        shown.key,
        `${pen.truncate(shown.not_a_sign ? 'false positive' : (shown.word ?? nameOf(shown.class_id)))}${shown.occluded ? ' (occluded)' : ''}${isProposed ? confidenceText : gateText}`,
      ),
      { where: 'above', weight: isSelected ? 2 : 1, thin: shown.origin === 'interpolated', dashed: isProposed, guarded: isSelected },
    );
    if (shown.origin === 'corrected') pen.diamond(layer, box);
    if (review.marked.includes(shown.key)) pen.mark(box);
    if (isSelected && modeOf(review).onTrackClick === null) pen.handles(layer, box);
  }
  pen.labels();
  return counts;
}

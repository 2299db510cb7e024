// @ts-check
/** Maps entities of a recording to tracks and back. Pure. */

import { shownSigns } from '../../review/shown_tracks.js';

/** @typedef {import('../../types.js').Overlay} Overlay */

/**
 * The track that was selected in the viewer.
 *
 * @param {string|null} entity              path, such as `/video/results` or `/tracks/m7/gate/l_positive`
 * @param {number|null} instance            index of its box
 * @param {Overlay|undefined} overlay overlay of the viewer's frame
 * @param {readonly string[]} [corrected]   from `correctedKeysInOrder`; empty if the recording has other corrections than the page
 * @returns {string|null}   key of the track
 */
export function trackOf(entity, instance, overlay, corrected = []) {
  if (entity === null) return null;
  const parts = entity.split('/').filter(Boolean);
  if (parts[0] === 'tracks') return /^m\d+$/.test(parts[1] ?? '') ? parts[1] : null;
  if (parts[0] !== 'video' || instance === null) return null;
  if (parts[1] === 'corrected') return corrected[instance] ?? null;
  if (!overlay) return null;
  const id = idsOf(parts[1] ?? '', overlay)[instance] ?? null;
  return id === null ? null : `m${id}`;
}

/**
 * Keys of the corrected boxes of a frame, in the order of the recording (`app/compare/annotation.py`): engine tracks by
 * number, then those that people made.
 *
 * @param {import('../../state-types.js').ReviewState} review
 * @returns {string[]}
 */
export function correctedKeysInOrder(review) {
  const keys = shownSigns(review).map(({ key }) => key);
  const engine = keys.filter((key) => key.startsWith('m')).sort((a, b) => Number(a.slice(1)) - Number(b.slice(1)));
  return [...engine, ...keys.filter((key) => !key.startsWith('m')).sort()];
}

/**
 * The entity of a track: its box in the frame, else its states.
 *
 * @param {string} key
 * @param {Overlay|undefined} overlay
 * @returns {string|null}   null: the recording has no entity for it
 */
export function entityOf(key, overlay) {
  if (!/^m\d+$/.test(key)) return null;
  const index = overlay ? idsOf('results', overlay).indexOf(Number(key.slice(1))) : -1;
  return index >= 0 ? `video/results[#${index}]` : `tracks/${key}/state`;
}

/**
 * Track numbers of the boxes of a layer, in the order of the recording (`tsr_engine/recording/from_evidence.py`).
 *
 * @param {string} layer
 * @param {Overlay} overlay
 * @returns {(number|null)[]}
 */
function idsOf(layer, { tracks, detections }) {
  /** @param {(track: import('../../types.js').OverlayTrack) => unknown} has */
  const sorted = (has) =>
    tracks
      .filter(has)
      .map(({ id }) => id)
      .sort((a, b) => a - b);
  switch (layer) {
    case 'results':
      return tracks.map(({ id }) => id);
    case 'detections':
    case 'detections_raw':
      return detections.map(({ track }) => track);
    case 'predictions':
    case 'innovation':
      return sorted(({ prediction }) => prediction !== null);
    case 'search':
    case 'relocalisations':
    case 'runner_up':
      return sorted(({ relocalisation }) => relocalisation !== null);
    default:
      return [];
  }
}

// @ts-check
/** Which track an entity of a recording is about, and the other way round. Pure. */

/** @typedef {import('../../types.js').Overlay} Overlay */

/**
 * The track that was picked in the viewer.
 *
 * @param {string|null} entity        path, such as `/video/results` or `/tracks/m7/gate/l_positive`
 * @param {number|null} instance      which of its boxes
 * @param {Overlay|undefined} overlay of the frame that the viewer shows
 * @returns {string|null}   key of the track
 */
export function trackOf(entity, instance, overlay) {
  if (entity === null) return null;
  const parts = entity.split('/').filter(Boolean);
  if (parts[0] === 'tracks') return /^m\d+$/.test(parts[1] ?? '') ? parts[1] : null;
  if (parts[0] !== 'video' || instance === null || !overlay) return null;
  const id = idsOf(parts[1] ?? '', overlay)[instance] ?? null;
  return id === null ? null : `m${id}`;
}

/**
 * The entity that stands for a track: its box in the frame, else its states.
 *
 * @param {string} key
 * @param {Overlay|undefined} overlay
 * @returns {string|null}   null: the recording has nothing about it
 */
export function entityOf(key, overlay) {
  if (!/^m\d+$/.test(key)) return null;
  const place = overlay ? idsOf('results', overlay).indexOf(Number(key.slice(1))) : -1;
  return place >= 0 ? `video/results[#${place}]` : `tracks/${key}/state`;
}

/**
 * Track numbers of the boxes of a layer, in the order of the recording (`tsr_engine/recording/stored.py`).
 *
 * @param {string} layer
 * @param {Overlay} overlay
 * @returns {(number|null)[]}
 */
function idsOf(layer, {tracks, detections}) {
  /** @param {(track: import('../../types.js').OverlayTrack) => unknown} has */
  const sorted = (has) => tracks.filter(has).map(({id}) => id).sort((a, b) => a - b);
  switch (layer) {
    case 'results': return tracks.map(({id}) => id);
    case 'detections': case 'detections_raw': return detections.map(({track}) => track);
    case 'predictions': case 'innovation': return sorted(({prediction}) => prediction !== null);
    case 'search': case 'relocalisations': case 'runner_up': return sorted(({relocalisation}) => relocalisation !== null);
    default: return [];
  }
}

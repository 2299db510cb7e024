// @ts-check
/** Data as the server sends it, for tests. */

/** A key frame. @param {Partial<import('../../static/js/types.js').KeyFrame>} [fields] @returns {import('../../static/js/types.js').KeyFrame} */
export const keyFrame = (fields) => ({
  box: null,
  occluded: false,
  outside: false,
  interpolate: true,
  class_id: null,
  followed: false,
  ...fields,
});

/** A track in a frame, as the server sends it. @param {object} fields @returns {any} */
export const overlayTrack = (fields) => ({
  id: 1,
  state: 'confirmed',
  source: 0,
  class_id: 1,
  share: 1,
  prediction: null,
  gate: null,
  relocalisation: null,
  ...fields,
});

/** The frames of a video at a constant rate. @type {import('../../static/js/types.js').FrameTableData} */
export const FRAME_TABLE = { frames: 5000, time_base: [1, 25], first_pts: 0, steps: [[1, 4999]], keys: [0], corrupt: [] };

// @ts-check
/** The value lanes of the selected track, one below the other. Pure. */

/** @typedef {{id: string, label: string, hint: string, height: number, kind: 'gate'|'line'|'votes', series: import('./detail_columns.js').SeriesName[]}} SubLane */

/** In screen order. Verdict and class come first, so that they are visible without scrolling. Heights in design px. @type {readonly SubLane[]} */
export const SUB_LANES = [
  {
    id: 'gate',
    label: 'Gate score',
    hint: 'The gate’s product on a log axis; lower is better, and below tau a prediction is confident',
    height: 68,
    kind: 'gate',
    series: ['l_positive'],
  },
  { id: 'votes', label: 'Class votes', hint: 'Fused share of the leading classes', height: 68, kind: 'votes', series: [] },
  {
    id: 'symmetry',
    label: 'Symmetry',
    hint: 'First factor: 1 / mirror symmetry of the crop, or the run’s symmetry_floor if that is larger; low is good',
    height: 32,
    kind: 'line',
    series: ['symmetry'],
  },
  {
    id: 'hash',
    label: 'Appearance distance (bits)',
    hint: 'Second factor: bits that differ from the mean of earlier crops',
    height: 32,
    kind: 'line',
    series: ['hash_distance'],
  },
  {
    id: 'position',
    label: 'Position',
    hint: 'Third factor: distance to the result of the previous frame',
    height: 32,
    kind: 'line',
    series: ['position_distance'],
  },
  {
    id: 'score',
    label: 'Score',
    hint: 'Offline detector: with the prior (solid) and without (dashed)',
    height: 44,
    kind: 'line',
    series: ['score', 'raw_score'],
  },
  {
    id: 'svm',
    label: 'SVM',
    hint: 'Online detector: decision value of the relocalisation',
    height: 36,
    kind: 'line',
    series: ['decision'],
  },
  { id: 'weight', label: 'Weight w', hint: 'Weight of each frame’s vote in the fusion', height: 32, kind: 'line', series: ['weight'] },
];

/** The visible lanes. @param {import('../state-types.js').LanesView} view @returns {readonly SubLane[]} */
export const shownLanes = ({ folded, lane }) =>
  folded ? SUB_LANES.filter(({ id }) => id === (SUB_LANES.some((one) => one.id === lane) ? lane : 'gate')) : SUB_LANES;

/** @param {number} unit @param {readonly SubLane[]} lanes @returns {number} total height, px */
export function detailHeight(unit, lanes) {
  return lanes.reduce((sum, lane) => sum + Math.round(lane.height * unit), 0);
}

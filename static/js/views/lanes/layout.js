// @ts-check
/** The elements of the lanes, without behaviour. */

import { h, selectInput, setText } from '../dom.js';
import { icon, iconButton } from '../icons.js';
import { SUB_LANES } from '../../model/sub_lanes.js';
import { SOURCES } from './palette.js';

const NAMES = { detected: 'Detected', predicted: 'Predicted', relocalised: 'Re-detected', corrected: 'Corrected' };

/** @typedef {ReturnType<typeof createLayout>} LanesLayout */

export function createLayout() {
  /** @param {string} name */
  const canvas = (name) => h('canvas', { class: `lanes-canvas ${name}`, 'aria-hidden': 'true' });
  const parts = {
    overview: canvas('lanes-overview-canvas'),
    axis: canvas('lanes-axis-canvas'),
    tracks: canvas('lanes-tracks-canvas'),
    detail: canvas('lanes-detail-canvas'),
    window: h('div.lanes-window'),
    overviewCursor: h('div.lanes-overview-cursor'),
    spacer: h('div.lanes-spacer'),
    playhead: h('div.lanes-playhead'),
    hover: h('div.lanes-hover'),
    readout: h('span.lanes-readout', { 'aria-hidden': 'true' }),
    count: h('span.muted.small.truncate'),
    detailName: h('span.lanes-detail-name.truncate'),
    flips: h('span.lanes-flips.small'),
    legend: h('ul.lanes-votes-legend'),
    zoomOut: iconButton('zoom_out', 'Zoom out (wheel)'),
    zoomIn: iconButton('zoom_in', 'Zoom in (wheel)'),
    fit: iconButton('fit', 'Show the whole drive'),
    toTrack: h('button.btn.btn-small.btn-quiet', { title: 'Show the selected track from its first to its last frame' }, 'Fit track'),
    fold: h('button.btn.btn-small.btn-quiet', { title: 'All lanes, or only the chosen one (Shift+L)' }, 'All lanes'),
    chosen: selectInput(
      { class: 'select lanes-chosen', 'aria-label': 'Lane', title: 'The value lane shown below the bar of the selected track' },
      SUB_LANES.map(({ id, label }) => [id, label]),
    ),
    reset: h('button.btn.btn-small.btn-quiet', { title: 'Back to the tau of the run' }, 'Reset'),
    whatIf: h('button.btn.btn-small', icon('whatif'), h('span', 'What if tau = …')),
  };
  const values = SUB_LANES.map(() => h('span.lanes-value'));
  const names = SUB_LANES.map((lane, i) =>
    h(
      'div',
      { class: `lanes-lane-name lanes-lane-${lane.kind}`, title: lane.hint, style: { '--lane': String(lane.height) } },
      h('span.lanes-lane-title', h('span.truncate', lane.label), values[i]),
      lane.kind === 'gate' ? parts.flips : null,
      lane.kind === 'votes' ? parts.legend : null,
    ),
  );
  const gutter = h('div.lanes-gutter.lanes-detail-gutter', names);
  const overviewPlot = h(
    'div.lanes-plot',
    { title: 'The whole drive: tracks at once (height), open uncertainty (lower band)' },
    parts.overview,
    parts.window,
    parts.overviewCursor,
  );
  const axisPlot = h(
    'div.lanes-plot',
    {
      role: 'slider',
      tabindex: '0',
      'aria-label': 'Position in the video',
      title: 'Drag: move. Wheel: zoom. Arrow keys: step; + and -: zoom',
    },
    parts.axis,
  );
  const tracksPlot = h('div.lanes-plot.lanes-stick', parts.tracks);
  const tracksPane = h(
    'div.lanes-pane.lanes-tracks',
    { tabindex: '0', role: 'group', 'aria-label': 'Tracks over time; the queue lists them for the keyboard' },
    h('div.lanes-gutter'),
    tracksPlot,
    parts.spacer,
  );
  const detailPlot = h('div.lanes-plot', parts.detail);
  const detailPane = h(
    'div.lanes-pane.lanes-detail',
    { tabindex: '0', role: 'group', 'aria-label': 'Values of the selected track over time' },
    gutter,
    detailPlot,
  );
  const head = h(
    'div.lanes-head',
    h('h2.lanes-title', 'Timeline'),
    h(
      'ul.lanes-legend',
      SOURCES.map((name) => h('li', h('span', { class: `lanes-swatch lanes-swatch-${name}` }), NAMES[name])),
    ),
    parts.readout,
    h('span.grow'),
    parts.fold,
    parts.zoomOut,
    parts.zoomIn,
    parts.fit,
  );
  const detailHead = h('div.lanes-detail-head', parts.detailName, h('span.grow'), parts.chosen, parts.reset, parts.whatIf, parts.toTrack);
  const body = h(
    'div.lanes-body',
    h('div.lanes-strip.lanes-overview', h('div.lanes-gutter', h('span.small.muted', 'Drive')), overviewPlot),
    h('div.lanes-strip.lanes-axis', h('div.lanes-gutter', parts.count), axisPlot),
    tracksPane,
    detailHead,
    detailPane,
    h('div.lanes-marks', { 'aria-hidden': 'true' }, parts.hover, parts.playhead),
  );
  const element = h('section.lanes.panel', { 'aria-label': 'Timeline' }, head, body);
  return { ...parts, element, body, names, values, overviewPlot, axisPlot, tracksPlot, tracksPane, detailPlot, detailPane, detailHead };
}

/**
 * The legend of the stacked votes.
 *
 * @param {HTMLElement} list
 * @param {{name: string, share: string, colour: string}[]} rows
 */
export function fillLegend(list, rows) {
  while (list.children.length > rows.length) list.lastElementChild?.remove();
  rows.forEach((row, i) => {
    const item =
      /** @type {HTMLElement|undefined} */ (list.children[i]) ??
      list.appendChild(h('li.lanes-votes-row', h('span.swatch'), h('span.truncate'), h('span.lanes-value')));
    /** @type {HTMLElement} */ (item.children[0]).style.setProperty('--colour', row.colour);
    setText(item.children[1], row.name);
    item.title = row.name;
    setText(item.children[2], row.share);
  });
}

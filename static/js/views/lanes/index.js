// @ts-check
/**
 * Timeline: the tracks of the drive and the values behind the selected one, on one time axis.
 *
 * Playhead and hover line are elements that only move; canvases are repainted only when their content changes.
 */
import { detailColumns } from '../../model/detail_columns.js';
import { barAt, barName, buildDensity, buildLaneIndex, withVerdicts } from '../../model/lanes_lod.js';
import { symmetryHint } from '../../model/describe_events.js';
import { reveal, toFrame, toX } from '../../model/time_axis.js';
import { trackEntries } from '../../model/track_entries.js';
import { documentLane, isLoaded } from '../../model/track_lane.js';
import { trackName } from '../../model/track_name.js';
import { frameCount, pick as pickTrack } from '../../store/actions/review.js';
import { edit, seek, setTau, show } from '../app.js';
import { leaveKeysToPicture, setAttribute, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { createNoTracks } from '../no_tracks.js';
import { paintAxis, paintOverview } from './axis_painter.js';
import { SUB_LANES, detailHeight, shownLanes } from '../../model/sub_lanes.js';
import { paintDetail } from './detail_painter.js';
import { listenToControls, spanOf } from './controls.js';
import { createDriveFlips } from './drive_flips.js';
import { createEndHandle } from './end_handle.js';
import { createFollowingStrip } from './following_strip.js';
import { createFrame } from './frame.js';
import { prepare, readPalette } from './palette.js';
import { secondsOf } from './seconds.js';
import { placeMarks, showValues } from './readouts.js';
import { createTauSlider } from './tau_slider.js';
import { paintTracks } from './tracks_painter.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('../../state-types.js').ReviewState} ReviewState */

const ROW = 20;
const FIRST_FACTOR = SUB_LANES.findIndex(({ id }) => id === 'symmetry');

/** @param {import('../app.js').ViewApp} app */
export function createLanes(app) {
  const parts = createFrame();
  const empty = createNoTracks(app, 'lanes-empty');
  parts.body.append(empty.element);
  const proposal = createFollowingStrip();
  parts.tracksPane.before(proposal.element);
  leaveKeysToPicture(parts.element);
  const life = new AbortController();
  const { signal } = life;
  const slider = createTauSlider((tau) => setTau(app, tau), signal);
  parts.detailPlot.append(slider.element);
  const driveFlips = createDriveFlips(app, signal);
  parts.reset.before(driveFlips.element);
  const ending = createEndHandle(
    {
      look: (frame) => seek(app, frame),
      end: (key, last) => void edit(app, key, { name: 'delete_from', frame: last + 1 }),
    },
    signal,
  );
  parts.tracksPlot.append(ending.element);

  let palette = readPalette(document.documentElement);
  /** @type {State|null} */ let state = null;
  /** @type {ReviewState|null} */ let old = null;
  let index = buildLaneIndex([], null, {});
  let density = buildDensity([], 1);
  /** @type {import('../../model/detail_columns.js').DetailColumns|null} */ let columns = null;
  /** @type {import('../../types.js').TrackLane|null} */ let lane = null;
  let width = 0;
  let tracksHeight = 0;
  let gutter = 0;
  /** @type {number|null} */ let hovered = null;
  let scheduled = 0;
  /** A selected track whose row has not come into view yet. @type {string|null} */ let awaited = null;
  let lanes = shownLanes({ folded: false, lane: '' });
  /** @type {Map<number, {text: string, width: number}>} */ const names = new Map();
  const dirty = { overview: true, tracks: true, detail: true };

  const review = () => app.store.get().review;
  const rowHeight = () => Math.round(ROW * palette.unit);

  /** @param {number} classId */
  const label = (classId) => {
    let found = names.get(classId);
    if (found === undefined) {
      const ctx = parts.tracks.getContext('2d');
      const text = barName(state?.labels ?? [], classId);
      if (ctx) ctx.font = palette.smallFont;
      found = { text, width: ctx ? ctx.measureText(text).width : 0 };
      names.set(classId, found);
    }
    return found;
  };

  /** @param {number} x @param {number} y */
  function pick(x, y) {
    const r = review();
    if (r === null) return;
    const span = spanOf(r);
    const row = Math.floor((y + parts.tracksPane.scrollTop) / rowHeight());
    const bar = barAt(index, row, toFrame(span, x, width), (3 * (span.last - span.first)) / Math.max(1, width));
    if (bar >= 0) app.store.dispatch(pickTrack, index.key[bar]);
  }

  listenToControls(
    app,
    parts,
    proposal.plot,
    {
      width: () => width,
      hover(x) {
        hovered = x;
        later();
      },
      pick,
      selected() {
        const bar = index.barOf.get(review()?.selected ?? '');
        return bar === undefined ? null : { first: index.first[bar], last: index.last[bar] };
      },
    },
    signal,
  );
  parts.tracksPane.addEventListener(
    'scroll',
    () => {
      dirty.tracks = true;
      later();
    },
    { signal, passive: true },
  );

  const observer = new ResizeObserver(() => measure());
  observer.observe(parts.tracksPane);
  observer.observe(parts.body);
  const restyle = () => {
    palette = readPalette(document.documentElement);
    names.clear();
    measure();
  };
  const themes = new MutationObserver(restyle);
  themes.observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme'] });
  globalThis.addEventListener('resize', restyle, { signal });

  function measure() {
    if (!parts.element.isConnected) return;
    const plotBox = parts.tracksPlot.getBoundingClientRect();
    gutter = plotBox.left - parts.body.getBoundingClientRect().left;
    width = Math.max(
      0,
      Math.floor(parts.tracksPane.getBoundingClientRect().left + parts.tracksPane.clientLeft + parts.tracksPane.clientWidth - plotBox.left),
    );
    const before = tracksHeight;
    tracksHeight = parts.tracksPane.clientHeight;
    if (tracksHeight < before && isInView(review()?.selected, before)) awaited = review()?.selected ?? null;
    comeIntoView();
    parts.element.style.setProperty('--lanes-plot-width', `${width}px`);
    dirty.overview = dirty.tracks = dirty.detail = true;
    later();
  }

  /** Schedule one paint in the next animation frame. */
  function later() {
    if (scheduled === 0) scheduled = requestAnimationFrame(paint);
  }

  function paint() {
    scheduled = 0;
    const r = state?.review ?? null;
    if (r === null || width === 0) return;
    const span = spanOf(r);
    const frames = frameCount(r);
    const { ratio } = palette;
    if (dirty.overview) {
      const height = parts.overviewPlot.clientHeight;
      const ctx = prepare(parts.overview, width, height, ratio);
      if (ctx) paintOverview(ctx, { width, height, frames }, density, palette);
    }
    if (dirty.tracks) {
      const height = parts.axisPlot.clientHeight;
      const axis = prepare(parts.axis, width, height, ratio);
      if (axis) paintAxis(axis, { width, height, span, frames }, palette, (frame) => secondsOf(r, frame));
      const ctx = prepare(parts.tracks, width, tracksHeight, ratio);
      const view = {
        width,
        height: tracksHeight,
        scroll: parts.tracksPane.scrollTop,
        rowHeight: rowHeight(),
        span,
        selected: r.selected,
        marked: r.marked,
      };
      if (ctx) paintTracks(ctx, index, view, palette, label);
    }
    if (dirty.detail && columns && lane) {
      const ctx = prepare(parts.detail, width, detailHeight(palette.unit, lanes), ratio);
      if (ctx) paintDetail(ctx, columns, { width, span, tau: r.tau ?? lane.tau, lanes }, palette);
    }
    if (old?.following || !proposal.element.hidden) proposal.paint(r.following, width, span, palette);
    dirty.overview = dirty.tracks = dirty.detail = false;
    ending.update(endOf(r, span));
    const frame = placeMarks(parts, { review: r, span, frames, width, gutter, hovered });
    showValues(parts, slider, { review: r, frame, columns, lane, labels: state?.labels ?? [], palette });
  }

  /** The end of the selected bar, while it is visible. @param {ReviewState} r @param {{first: number, last: number}} span */
  function endOf(r, span) {
    const bar = index.barOf.get(r.selected ?? '');
    if (bar === undefined || r.selected === null) return null;
    const [first, last, x] = [index.first[bar], index.last[bar], toX(span, index.last[bar] + 1, width)];
    const y = index.row[bar] * rowHeight() - parts.tracksPane.scrollTop;
    return x < 0 || x > width || y <= -rowHeight() || y >= tracksHeight
      ? null
      : { key: r.selected, first, last, x, y, height: rowHeight(), scale: width / (span.last - span.first) };
  }

  /** @param {State['lanesView']} view */
  function refreshLanes(view) {
    lanes = shownLanes(view);
    SUB_LANES.forEach((sub, i) => {
      parts.names[i].hidden = !lanes.includes(sub);
    });
    slider.element.hidden = !lanes.includes(SUB_LANES[0]);
    parts.chosen.hidden = !view.folded;
    parts.chosen.value = lanes[0].id;
    setText(parts.fold, view.folded ? 'All lanes' : 'Fold lanes');
    parts.element.classList.toggle('lanes-folded', view.folded);
    parts.element.style.setProperty('--lanes-full', String(detailHeight(1, lanes)));
    measure();
  }

  /** @param {ReviewState} r */
  function refreshData(r) {
    if (
      old &&
      old.tracks === r.tracks &&
      old.lanes === r.lanes &&
      old.docs === r.docs &&
      old.video.frames === r.video.frames &&
      old.run?.state === r.run?.state &&
      old.timebase === r.timebase
    )
      return;
    const entries = trackEntries(r.tracks, r.docs);
    const judged = old && old.tracks === r.tracks && old.lanes === r.lanes ? withVerdicts(index, entries, old.docs, r.docs) : null;
    index = judged ?? buildLaneIndex(entries, r.lanes, r.docs);
    density = buildDensity(entries, frameCount(r));
    parts.spacer.style.setProperty('height', `${index.rows * rowHeight()}px`);
    setText(parts.count, plural(index.count, 'track'));
    dirty.overview = dirty.tracks = true;
    empty.update(r, index.count);
  }

  /** @param {ReviewState} r */
  function refreshSelection(r) {
    const doc = r.selected ? r.docs[r.selected] : undefined;
    const found = r.selected ? (documentLane(r.selected, doc, r.laneOf)?.lane ?? null) : null;
    if (found !== lane) {
      lane = found;
      columns = lane ? detailColumns(lane) : null;
      if (lane) setAttribute(parts.names[FIRST_FACTOR], 'title', symmetryHint(lane.symmetry_floor));
      dirty.detail = true;
      measure();
    }
    parts.detailPane.hidden = lane === null;
    parts.detailHead.hidden = r.selected === null;
    if (!old || old.selected !== r.selected) {
      dirty.tracks = true;
      awaited = r.selected;
    }
    comeIntoView();
    const bar = index.barOf.get(r.selected ?? '');
    const values = lane !== null || !r.selected ? '' : isLoaded(r.selected, doc, r.laneOf) ? 'the engine has no values of it' : 'loading…';
    const gone = doc?.merged_into ? `merged into ${trackName(doc.merged_into)}` : doc?.gone ? 'deleted' : '';
    const facts = (bar === undefined ? [gone] : [label(index.classId[bar]).text, values]).filter(Boolean);
    setText(parts.detailName, r.selected && facts.length ? [`Track ${trackName(r.selected, doc)}`, ...facts].join(' · ') : '');
  }

  /** @param {string|null|undefined} key @param {number} height   height of the pane, px */
  function isInView(key, height) {
    const bar = index.barOf.get(key ?? '');
    if (bar === undefined) return false;
    const top = index.row[bar] * rowHeight() - parts.tracksPane.scrollTop;
    return top >= 0 && top + rowHeight() <= height;
  }

  /** Scroll the row of the awaited track into view when the row and the pane exist. */
  function comeIntoView() {
    const bar = index.barOf.get(awaited ?? '');
    const pane = parts.tracksPane;
    if (bar === undefined || pane.clientHeight === 0) return;
    if (!isInView(awaited, pane.clientHeight))
      pane.scrollTop = index.row[bar] * rowHeight() - Math.max(0, pane.clientHeight - rowHeight()) / 2;
    awaited = null;
  }

  return {
    element: parts.element,
    /** @param {State} next */
    update(next) {
      if (next.labels !== state?.labels) {
        names.clear();
        dirty.tracks = true;
        later();
      }
      if (next.lanesView !== state?.lanesView) refreshLanes(next.lanesView);
      state = next;
      const r = next.review;
      if (r === null || r === old) return;
      refreshData(r);
      refreshSelection(r);
      if (!old || old.span !== r.span || old.video.frames !== r.video.frames) dirty.tracks = dirty.detail = true;
      if (!old || old.tau !== r.tau) dirty.detail = true;
      driveFlips.update(r);
      if (!old || old.timebase !== r.timebase || old.marked !== r.marked) dirty.tracks = true;
      const moved = old !== null && old.frame !== r.frame;
      old = r;
      if (width === 0) measure();
      if (moved) {
        const span = spanOf(r);
        const shown = reveal(span, r.frame, frameCount(r));
        if (shown !== span) show(app, shown);
      }
      later();
    },
    destroy() {
      life.abort();
      observer.disconnect();
      themes.disconnect();
      cancelAnimationFrame(scheduled);
      parts.element.remove();
    },
  };
}

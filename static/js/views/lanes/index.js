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
import { frameCount, pick as pickTrack, seek, dragTau, showSpan } from '../../store/actions/review.js';
import { editTrack } from '../edit_track.js';
import { returnFocusToPicture, setAttribute, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { createNoTracks } from '../no_tracks.js';
import { paintAxis, paintOverview } from './axis_painter.js';
import { SUB_LANES, detailHeight, shownLanes } from '../../model/sub_lanes.js';
import { paintDetail } from './detail_painter.js';
import { listenToControls, shownSpan } from './controls.js';
import { createDriveFlips } from './drive_flips.js';
import { createEndHandle } from './end_handle.js';
import { createFollowingStrip } from './following_strip.js';
import { createLayout } from './layout.js';
import { prepareCanvas, readPalette } from './palette.js';
import { placeMarks, secondsAt, showValues } from './readouts.js';
import { createTauSlider } from './tau_slider.js';
import { paintTracks } from './tracks_painter.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('../../state-types.js').ReviewState} ReviewState */

const ROW_HEIGHT = 20;
const SYMMETRY_LANE = SUB_LANES.findIndex(({ id }) => id === 'symmetry');

/** @param {import('../../page-types.js').ViewApp} app */
export function createLanes(app) {
  const parts = createLayout();
  const noTracks = createNoTracks(app, 'lanes-empty');
  parts.body.append(noTracks.element);
  const proposalStrip = createFollowingStrip();
  parts.tracksPane.before(proposalStrip.element);
  returnFocusToPicture(parts.element);
  const lifetime = new AbortController();
  const { signal } = lifetime;
  const slider = createTauSlider((tau) => app.store.dispatch(dragTau, tau));
  parts.detailPlot.append(slider.element);
  const driveFlips = createDriveFlips(app, signal);
  parts.reset.before(driveFlips.element);
  const endHandle = createEndHandle(
    {
      showFrame: (frame) => app.store.dispatch(seek, frame),
      endTrack: (key, last) => void editTrack(app, key, { name: 'delete_from', frame: last + 1 }),
    },
    signal,
  );
  parts.tracksPlot.append(endHandle.element);

  let palette = readPalette(document.documentElement);
  /** @type {State|null} */ let state = null;
  /** @type {ReviewState|null} */ let previousReview = null;
  let index = buildLaneIndex([], null, {});
  let density = buildDensity([], 1);
  /** @type {import('../../model/detail_columns.js').DetailColumns|null} */ let columns = null;
  /** @type {import('../../types.js').TrackLane|null} */ let lane = null;
  let width = 0;
  let tracksHeight = 0;
  let gutter = 0;
  /** @type {number|null} */ let hovered = null;
  let scheduled = 0;
  /** A selected track whose row has not come into view yet. @type {string|null} */ let trackToReveal = null;
  let lanes = shownLanes({ folded: false, lane: '' });
  /** @type {Map<number, {text: string, width: number}>} */ const names = new Map();
  const dirty = { overview: true, tracks: true, detail: true };

  const getReview = () => app.store.get().review;
  const rowHeight = () => Math.round(ROW_HEIGHT * palette.unit);

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
    const review = getReview();
    if (review === null) return;
    const span = shownSpan(review);
    const row = Math.floor((y + parts.tracksPane.scrollTop) / rowHeight());
    const bar = barAt(index, row, toFrame(span, x, width), (3 * (span.last - span.first)) / Math.max(1, width));
    if (bar >= 0) app.store.dispatch(pickTrack, index.key[bar]);
  }

  listenToControls(app, parts, proposalStrip.plot, {
    width: () => width,
    hover(x) {
      hovered = x;
      schedulePaint();
    },
    pick,
    selected() {
      const bar = index.barOf.get(getReview()?.selected ?? '');
      return bar === undefined ? null : { first: index.first[bar], last: index.last[bar] };
    },
  });
  parts.tracksPane.addEventListener(
    'scroll',
    () => {
      dirty.tracks = true;
      schedulePaint();
    },
    { signal, passive: true },
  );

  const observer = new ResizeObserver(() => measure());
  observer.observe(parts.tracksPane);
  observer.observe(parts.body);
  const onThemeChange = () => {
    palette = readPalette(document.documentElement);
    names.clear();
    measure();
  };
  const themeObserver = new MutationObserver(onThemeChange);
  themeObserver.observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme'] });
  globalThis.addEventListener('resize', onThemeChange, { signal });

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
    if (tracksHeight < before && isInView(getReview()?.selected, before)) trackToReveal = getReview()?.selected ?? null;
    revealTrack();
    parts.element.style.setProperty('--lanes-plot-width', `${width}px`);
    dirty.overview = dirty.tracks = dirty.detail = true;
    schedulePaint();
  }

  /** Schedule one paint in the next animation frame. */
  function schedulePaint() {
    if (scheduled === 0) scheduled = requestAnimationFrame(paint);
  }

  function paint() {
    scheduled = 0;
    const review = state?.review ?? null;
    if (review === null || width === 0) return;
    const span = shownSpan(review);
    const frames = frameCount(review);
    const { ratio } = palette;
    if (dirty.overview) {
      const height = parts.overviewPlot.clientHeight;
      const ctx = prepareCanvas(parts.overview, width, height, ratio);
      if (ctx) paintOverview(ctx, { width, height, frames }, density, palette);
    }
    if (dirty.tracks) {
      const height = parts.axisPlot.clientHeight;
      const axis = prepareCanvas(parts.axis, width, height, ratio);
      if (axis) paintAxis(axis, { width, height, span, frames }, palette, (frame) => secondsAt(review, frame));
      const ctx = prepareCanvas(parts.tracks, width, tracksHeight, ratio);
      const view = {
        width,
        height: tracksHeight,
        scroll: parts.tracksPane.scrollTop,
        rowHeight: rowHeight(),
        span,
        selected: review.selected,
        marked: review.marked,
      };
      if (ctx) paintTracks(ctx, index, view, palette, label);
    }
    if (dirty.detail && columns && lane) {
      const ctx = prepareCanvas(parts.detail, width, detailHeight(palette.unit, lanes), ratio);
      if (ctx) paintDetail(ctx, columns, { width, span, tau: review.tau ?? lane.tau, lanes }, palette);
    }
    if (previousReview?.following || !proposalStrip.element.hidden) proposalStrip.paint(review.following, width, span, palette);
    dirty.overview = dirty.tracks = dirty.detail = false;
    endHandle.update(endOfSelectedBar(review, span));
    const frame = placeMarks(parts, { review, span, frames, width, gutter, hovered });
    showValues(parts, slider, { review, frame, columns, lane, labels: state?.labels ?? [], palette });
  }

  /** The end of the selected bar, while it is visible. @param {ReviewState} review @param {{first: number, last: number}} span */
  function endOfSelectedBar(review, span) {
    const bar = index.barOf.get(review.selected ?? '');
    if (bar === undefined || review.selected === null) return null;
    const [first, last, x] = [index.first[bar], index.last[bar], toX(span, index.last[bar] + 1, width)];
    const y = index.row[bar] * rowHeight() - parts.tracksPane.scrollTop;
    return x < 0 || x > width || y <= -rowHeight() || y >= tracksHeight
      ? null
      : { key: review.selected, first, last, x, y, height: rowHeight(), scale: width / (span.last - span.first) };
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

  /** @param {ReviewState} review */
  function refreshData(review) {
    if (
      previousReview &&
      previousReview.tracks === review.tracks &&
      previousReview.lanes === review.lanes &&
      previousReview.docs === review.docs &&
      previousReview.video.frames === review.video.frames &&
      previousReview.run?.state === review.run?.state &&
      previousReview.timebase === review.timebase
    )
      return;
    const entries = trackEntries(review.tracks, review.docs);
    const updated =
      previousReview && previousReview.tracks === review.tracks && previousReview.lanes === review.lanes
        ? withVerdicts(index, entries, previousReview.docs, review.docs)
        : null;
    index = updated ?? buildLaneIndex(entries, review.lanes, review.docs);
    density = buildDensity(entries, frameCount(review));
    parts.spacer.style.setProperty('height', `${index.rows * rowHeight()}px`);
    setText(parts.count, plural(index.count, 'track'));
    dirty.overview = dirty.tracks = true;
    noTracks.update(review, index.count);
  }

  /** @param {ReviewState} review */
  function refreshSelection(review) {
    const doc = review.selected ? review.docs[review.selected] : undefined;
    const foundLane = review.selected ? (documentLane(review.selected, doc, review.laneOf)?.lane ?? null) : null;
    if (foundLane !== lane) {
      lane = foundLane;
      columns = lane ? detailColumns(lane) : null;
      if (lane) setAttribute(parts.names[SYMMETRY_LANE], 'title', symmetryHint(lane.symmetry_floor));
      dirty.detail = true;
      measure();
    }
    parts.detailPane.hidden = lane === null;
    parts.detailHead.hidden = review.selected === null;
    if (!previousReview || previousReview.selected !== review.selected) {
      dirty.tracks = true;
      trackToReveal = review.selected;
    }
    revealTrack();
    const bar = index.barOf.get(review.selected ?? '');
    const values =
      lane !== null || !review.selected
        ? ''
        : isLoaded(review.selected, doc, review.laneOf)
          ? 'the engine has no values of it'
          : 'loading…';
    const deletedText = doc?.merged_into ? `merged into ${trackName(doc.merged_into)}` : doc?.gone ? 'deleted' : '';
    const details = (bar === undefined ? [deletedText] : [label(index.classId[bar]).text, values]).filter(Boolean);
    setText(
      parts.detailName,
      review.selected && details.length ? [`Track ${trackName(review.selected, doc)}`, ...details].join(' · ') : '',
    );
  }

  /** @param {string|null|undefined} key @param {number} height   height of the pane, px */
  function isInView(key, height) {
    const bar = index.barOf.get(key ?? '');
    if (bar === undefined) return false;
    const top = index.row[bar] * rowHeight() - parts.tracksPane.scrollTop;
    return top >= 0 && top + rowHeight() <= height;
  }

  /** Scroll the row of the awaited track into view when the row and the pane exist. */
  function revealTrack() {
    const bar = index.barOf.get(trackToReveal ?? '');
    const pane = parts.tracksPane;
    if (bar === undefined || pane.clientHeight === 0) return;
    if (!isInView(trackToReveal, pane.clientHeight))
      pane.scrollTop = index.row[bar] * rowHeight() - Math.max(0, pane.clientHeight - rowHeight()) / 2;
    trackToReveal = null;
  }

  return {
    element: parts.element,
    /** @param {State} next */
    update(next) {
      if (next.labels !== state?.labels) {
        names.clear();
        dirty.tracks = true;
        schedulePaint();
      }
      if (next.lanesView !== state?.lanesView) refreshLanes(next.lanesView);
      state = next;
      const review = next.review;
      if (review === null || review === previousReview) return;
      refreshData(review);
      refreshSelection(review);
      if (!previousReview || previousReview.span !== review.span || previousReview.video.frames !== review.video.frames)
        dirty.tracks = dirty.detail = true;
      if (!previousReview || previousReview.tau !== review.tau) dirty.detail = true;
      driveFlips.update(review);
      if (!previousReview || previousReview.timebase !== review.timebase || previousReview.marked !== review.marked) dirty.tracks = true;
      const moved = previousReview !== null && previousReview.frame !== review.frame;
      previousReview = review;
      if (width === 0) measure();
      if (moved) {
        const span = shownSpan(review);
        const shown = reveal(span, review.frame, frameCount(review));
        if (shown !== span) app.store.dispatch(showSpan, shown);
      }
      schedulePaint();
    },
    destroy() {
      lifetime.abort();
      observer.disconnect();
      themeObserver.disconnect();
      cancelAnimationFrame(scheduled);
    },
  };
}

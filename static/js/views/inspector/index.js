// @ts-check
/** Inspector of the selected track: label and certainty, the engine's results frame by frame, and notes. */

import { trackEntries } from '../../model/track_entries.js';
import { documentLane, isLoaded, sentencesOfTrack } from '../../model/track_lane.js';
import { h } from '../dom.js';
import { createAttributes } from './attributes.js';
import { createCrops } from './crops.js';
import { createEvents } from './events.js';
import { createExplain } from './explain.js';
import { createHead } from './head.js';
import { createHistory } from './history.js';
import { createNotes } from './notes.js';
import { createPinned } from './pinned.js';
import { createRunInfo } from './run_info.js';

/** @typedef {import('../../state-types.js').State} State */

/** @param {import('../../page-types.js').App} app */
export function createInspector(app) {
  const lifetime = new AbortController();
  const explain = createExplain(app, lifetime.signal);
  const sections = [
    createHead(app),
    createPinned(app, lifetime.signal),
    createAttributes(app),
    explain,
    createCrops(app, lifetime.signal),
    createEvents(app),
    createNotes(app, lifetime.signal),
    createHistory(app, lifetime.signal),
  ];
  const runInfo = createRunInfo();
  const body = h(
    'div.inspector-track',
    sections.map((section) => section.element),
  );
  const empty = h(
    'div.empty',
    h(
      'p',
      'Select a track in the picture, the lanes or the queue. This panel explains its boxes and its label. J selects the most uncertain track.',
    ),
  );
  const element = h(
    'section.inspector.panel',
    { 'aria-label': 'Inspector' },
    h('div.inspector-scroll', { tabindex: '0', role: 'group', 'aria-label': 'Selected track' }, body, empty, runInfo.element),
  );
  /** @type {import('../../state-types.js').ReviewState|null} */ let previousReview = null;
  /** @type {State['labels']|null} */ let labels = null;
  /** @type {readonly import('../../model/track_entries.js').TrackEntry[]} */ let entries = [];
  /** @type {import('../../model/track_lane.js').DocumentLane|null} */ let shownLane = null;
  /** @type {import('../../model/describe_events.js').Sentence[]} */ let sentences = [];
  return {
    element,
    /** @param {State} state */
    update(state) {
      const review = state.review;
      if (review === null || (review === previousReview && state.labels === labels)) return;
      labels = state.labels;
      if (!previousReview || previousReview.tracks !== review.tracks || previousReview.docs !== review.docs)
        entries = trackEntries(review.tracks, review.docs);
      previousReview = review;
      const entry = entries.find((one) => one.key === review.selected) ?? null;
      body.hidden = entry === null;
      empty.hidden = entry !== null;
      runInfo.update(review.run);
      if (entry === null) return;
      const laneData = documentLane(entry.key, review.docs[entry.key], review.laneOf);
      if (laneData !== shownLane) sentences = laneData ? sentencesOfTrack(laneData) : [];
      shownLane = laneData;
      for (const section of sections)
        section.update({
          state,
          review,
          entry,
          laneData: laneData,
          lane: laneData?.lane ?? null,
          isLoaded: isLoaded(entry.key, review.docs[entry.key], review.laneOf),
          sentences,
          doc: review.docs[entry.key] ?? null,
        });
    },
    destroy: () => lifetime.abort(),
  };
}

/**
 * What every section receives.
 * @typedef {object} Inspected
 * @property {State} state
 * @property {import('../../state-types.js').ReviewState} review
 * @property {import('../../model/track_entries.js').TrackEntry} entry
 * @property {import('../../model/track_lane.js').DocumentLane|null} laneData       null: not loaded, or the engine has no values
 * @property {import('../../types.js').TrackLane|null} lane                         of `laneData`
 * @property {boolean} isLoaded                                                     without it, nothing is known yet of the engine's frames
 * @property {readonly import('../../model/describe_events.js').Sentence[]} sentences   events of the lane's track
 * @property {import('../../types.js').TrackDoc|null} doc                           null: nobody has changed it
 */

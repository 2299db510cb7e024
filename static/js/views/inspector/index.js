// @ts-check
/** Inspector of the selected track: label and certainty, the engine's results frame by frame, and notes. */

import { trackEntries } from '../../model/track_entries.js';
import { documentLane, sentencesOfTrack } from '../../model/track_lane.js';
import { h } from '../dom.js';
import { createAttributes } from './attributes.js';
import { createCrops } from './crops.js';
import { createEvents } from './events.js';
import { createExplain } from './explain.js';
import { createHead } from './head.js';
import { createHistory } from './history.js';
import { createNotes } from './notes.js';
import { createPinned } from './pinned.js';
import { createRunFacts } from './run_facts.js';

/** @typedef {import('../../state-types.js').State} State */

/** @param {import('../../page-types.js').App} app */
export function createInspector(app) {
  const life = new AbortController();
  const explain = createExplain(app, life.signal);
  const sections = [
    createHead(app, life.signal),
    createPinned(app, life.signal),
    createAttributes(app, life.signal),
    explain,
    createCrops(app, life.signal),
    createEvents(app, life.signal),
    createNotes(app, life.signal),
    createHistory(app, life.signal),
  ];
  const facts = createRunFacts();
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
    h('div.inspector-scroll', { tabindex: '0', role: 'group', 'aria-label': 'Selected track' }, body, empty, facts.element),
  );
  /** @type {import('../../state-types.js').ReviewState|null} */ let old = null;
  /** @type {State['labels']|null} */ let labels = null;
  /** @type {readonly import('../../model/track_entries.js').TrackEntry[]} */ let entries = [];
  /** @type {import('../../model/track_lane.js').DocumentLane|null} */ let reported = null;
  /** @type {import('../../model/describe_events.js').Sentence[]} */ let sentences = [];
  return {
    element,
    /** @param {State} state */
    update(state) {
      const review = state.review;
      if (review === null || (review === old && state.labels === labels)) return;
      labels = state.labels;
      if (!old || old.tracks !== review.tracks || old.docs !== review.docs) entries = trackEntries(review.tracks, review.docs);
      old = review;
      const entry = entries.find((one) => one.key === review.selected) ?? null;
      body.hidden = entry === null;
      empty.hidden = entry !== null;
      facts.update(review.run);
      if (entry === null) return;
      const found = documentLane(entry.key, review.docs[entry.key], review.laneOf);
      if (found !== reported) sentences = found ? sentencesOfTrack(found) : [];
      reported = found;
      for (const section of sections)
        section.update({ state, review, entry, found, lane: found?.lane ?? null, sentences, doc: review.docs[entry.key] ?? null });
    },
    destroy() {
      life.abort();
      element.remove();
    },
  };
}

/**
 * What every section receives.
 * @typedef {object} Inspected
 * @property {State} state
 * @property {import('../../state-types.js').ReviewState} review
 * @property {import('../../model/track_entries.js').TrackEntry} entry
 * @property {import('../../model/track_lane.js').DocumentLane|null} found   null: not loaded, or the engine has no values
 * @property {import('../../types.js').TrackLane|null} lane   of `found`
 * @property {readonly import('../../model/describe_events.js').Sentence[]} sentences   events of the lane's track
 * @property {import('../../types.js').TrackDoc|null} doc     null: nobody has changed it
 */

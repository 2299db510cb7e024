// @ts-check
/** Label, probability, runner-up and review state of the selected track. */

import { labelName, engineName, labelFor } from '../../model/labels.js';
import { describeLabels } from '../../model/describe_corrections.js';
import { countFrames } from '../../model/shown_spans.js';
import { setVerdict } from '../../operations/verdicts.js';
import { h, setAttribute, setText } from '../dom.js';
import { count, frameSpan, percent } from '../../model/format.js';
import { icon } from '../icons.js';
import { imageWithPlaceholder, setImageSource } from '../images.js';

/** @typedef {import('../../types.js').TrackDoc['review']} Review */
/** @type {{review: Review, label: string, icon: import('../icons.js').IconName, key: string, title?: string}[]} */
const CHOICES = [
  { review: 'accepted', label: 'Accept', icon: 'accept', key: 'A' },
  { review: 'rejected', label: 'False positive', icon: 'reject', key: 'X', title: 'Not a sign: training uses its boxes as background' },
  { review: 'needs_work', label: 'Needs work', icon: 'needs_work', key: 'W' },
];

/** @param {import('../../page-types.js').ViewApp} app */
export function createHead(app) {
  const picture = imageWithPlaceholder({ class: 'inspector-picture' });
  const name = h('h2.inspector-name', { dir: 'auto' });
  const sub = h('p.small.muted');
  const authorText = h('p.small.inspector-human');
  const leaderBar = h('span.inspector-own');
  const runnerUpBar = h('span.inspector-other');
  const margin = h('div.inspector-margin', { role: 'img' }, leaderBar, runnerUpBar);
  const votes = h('p.small.inspector-votes');
  /** @type {Review} */ let currentReview = 'open';
  let key = '';
  /** @param {Review} choice */
  const judge = (choice) => {
    const { review } = app.store.get();
    if (review) setVerdict(app, review, key, currentReview === choice ? 'open' : choice);
  };
  const buttons = CHOICES.map(({ review, label, icon: name }) =>
    h('button.btn.btn-small', { onclick: () => judge(review) }, icon(name), label),
  );
  return {
    element: h(
      'div.inspector-head',
      h('div.inspector-title', picture, h('div.grow', name, sub, authorText)),
      margin,
      votes,
      h('div.inspector-review', { role: 'group', 'aria-label': 'Review state' }, buttons),
    ),
    /** @param {import('./index.js').Inspected} inspected */
    update({ state, review, entry, laneData }) {
      /** @param {number|null|undefined} id */
      const nameOf = (id) => labelName(state.labels, id);
      key = entry.key;
      currentReview = entry.review;
      const url = labelFor(state.labels, entry.class_id)?.picture ?? null;
      picture.hidden = url === null;
      setImageSource(picture, url);
      setText(name, engineName(state.labels, entry.class_id, entry.word));
      setText(
        sub,
        `Track ${entry.name} · ${entry.first === entry.last ? 'frame' : 'frames'} ${frameSpan(entry.first, entry.last)} (${count(countFrames(entry.spans))})`,
      );
      const i = entry.column;
      const tracks = i < 0 ? null : review.tracks;
      const labelAuthor = describeLabels(review.docs[entry.key], tracks?.class_id[i] ?? null, nameOf, tracks?.word?.[i]);
      authorText.hidden = labelAuthor === null && entry.track !== null;
      setText(authorText, labelAuthor ?? (tracks ? 'Made by a person from the engine’s tracks.' : 'Drawn by a person.'));
      const read = entry.whole ? readingOf(tracks, i) : (laneData?.reading ?? null);
      margin.hidden = votes.hidden = read === null;
      leaderBar.style.setProperty('width', `${(read?.share ?? 0) * 100}%`);
      runnerUpBar.style.setProperty('width', `${(read?.runner_up_share ?? 0) * 100}%`);
      if (read) {
        const readName = engineName(state.labels, read.class_id, read.word);
        const runnerUpText =
          read.runner_up === null
            ? ''
            : `; runner-up ${engineName(state.labels, read.runner_up, read.runner_up_word)} ${percent(read.runner_up_share)}, margin ${percent(read.share - read.runner_up_share)}`;
        // for a part the engine has no result: the votes of its frames are summed and may give another class
        const subject = !entry.whole
          ? `These frames alone: ${readName}, fused probability`
          : entry.relabelled
            ? `The engine’s ${readName}: fused probability`
            : 'Fused probability';
        setText(votes, `${subject} ${percent(read.share)}${runnerUpText}`);
      }
      setAttribute(margin, 'aria-label', votes.textContent);
      buttons.forEach((button, index) => {
        const given = CHOICES[index].review === entry.review;
        setAttribute(button, 'aria-pressed', String(given));
        setAttribute(
          button,
          'title',
          given ? 'Click again to remove the verdict' : `${CHOICES[index].title ?? CHOICES[index].label} (${CHOICES[index].key})`,
        );
      });
    },
  };
}

/** The engine's class of a whole track. @param {import('../../types.js').TrackColumns|null} tracks @param {number} i @returns {import('../../model/track_lane.js').Reading|null} */
function readingOf(tracks, i) {
  const class_id = tracks?.class_id[i] ?? null;
  const share = tracks?.share[i] ?? null;
  if (!tracks || class_id === null || share === null) return null;
  return {
    class_id,
    word: tracks.word?.[i] ?? null,
    share,
    runner_up: tracks.runner_up[i],
    runner_up_word: tracks.runner_up_word?.[i] ?? null,
    runner_up_share: tracks.runner_up_share[i] ?? 0,
  };
}

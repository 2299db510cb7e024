// @ts-check
/** One row of the queue. */

import { NO_CLASS } from '../../model/documents.js';
import { labelFor } from '../../model/labels.js';
import { h, setAttribute, setText } from '../dom.js';
import { figure, frameSpan, roundPercent } from '../../model/format.js';
import { imageWithPlaceholder, setImageSource } from '../images.js';

const STATES = {
  open: { text: 'Open', tone: '' },
  accepted: { text: '✓ Accepted', tone: 'badge-good' },
  rejected: { text: '✕ False positive', tone: 'badge-bad' },
  needs_work: { text: '! Needs work', tone: 'badge-warn' },
};

/** @param {string} key   of the track */
export function createQueueRow(key) {
  const picture = imageWithPlaceholder({ class: 'queue-picture', loading: 'lazy', decoding: 'async' });
  const name = h('span.queue-name.truncate', { dir: 'auto' });
  const number = h('span.queue-number.muted.small');
  const badge = h('span.badge');
  const reasons = [0, 1].map(() => h('span.queue-reason.truncate.small.muted'));
  const span = h('span.queue-span.small.muted', { title: 'Frames' });
  const score = h('span.queue-score.truncate.small.muted', { title: 'Best score of its detections' });
  const uncertainty = h('span.queue-uncertainty', h('span'));
  const uncertaintyText = h('span.small.queue-uncertainty-text');
  const element = h(
    'div.queue-row',
    { role: 'option', id: `queue-${key}`, dataset: { key } },
    picture,
    h(
      'span.queue-text',
      h('span.queue-line', name, number, h('span.grow'), badge),
      h('span.queue-reasons', reasons),
      h('span.queue-line', span, score, h('span.grow'), uncertaintyText, uncertainty),
    ),
  );
  return {
    element,
    /**
     * @param {import('../../model/track_entries.js').TrackEntry} entry
     * @param {readonly import('../../types.js').Label[]} labels
     * @param {{index: number, size: number, top: number, height: number, selected: boolean, marked: boolean, hint: string}} view   marked: for a merge; hint: ends at which its sign may be visible further
     */
    update(entry, labels, view) {
      const label = labelFor(labels, entry.class_id);
      const address = label?.picture ?? null;
      element.style.setProperty('transform', `translateY(${view.top}px)`);
      element.style.setProperty('height', `${view.height}px`);
      setAttribute(element, 'aria-selected', String(view.selected));
      element.classList.toggle('queue-marked', view.marked);
      setAttribute(element, 'aria-posinset', view.index + 1);
      setAttribute(element, 'aria-setsize', view.size);
      setImageSource(picture, address);
      setText(name, label?.name ?? entry.word ?? (entry.class_id === NO_CLASS ? 'Not in the set' : 'No label yet'));
      setAttribute(name, 'title', entry.word === null ? null : `The engine’s name for it; the label set has no such label`);
      setText(
        number,
        `${entry.name}${entry.relabelled || entry.track === null ? ' · human' : ''}${entry.ignore ? ' · ignored' : ''}${entry.notes.length > 0 ? ` · ${entry.notes.length} ✎` : ''}${view.marked ? ' · to merge' : ''}`,
      );
      setText(badge, STATES[entry.review].text);
      badge.className = `badge ${STATES[entry.review].tone}`;
      const reasonsAndHint = view.hint ? [...entry.reasons, view.hint] : entry.reasons;
      const [first = 'Nothing unusual about it.', ...others] = reasonsAndHint;
      setText(reasons[0], first);
      setText(reasons[1], others.join(' '));
      // a single reason uses both lines; of several, each of the first two gets one line, because the second is often
      // about the class
      reasons[0].classList.toggle('truncate', others.length > 0);
      reasons[1].hidden = others.length === 0;
      element.title = [...reasonsAndHint, ...entry.notes.map((note) => `Note: ${note}`)].join('\n');
      setText(span, frameSpan(entry.first, entry.last));
      setText(score, Number.isFinite(entry.score) ? `· score ${figure(entry.score)}` : '');
      const known = entry.uncertainty !== null;
      setText(uncertaintyText, known ? `uncertainty ${roundPercent(entry.uncertainty)}` : 'uncertainty not known');
      setAttribute(uncertaintyText, 'title', known ? 'Probability that a person changes the track' : 'Imported runs do not store this');
      uncertainty.hidden = !known;
      /** @type {HTMLElement} */ (uncertainty.firstElementChild).style.setProperty('width', `${(entry.uncertainty ?? 0) * 100}%`);
    },
  };
}

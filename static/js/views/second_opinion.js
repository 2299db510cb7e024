// @ts-check
/**
 * Second opinions by sample: a reviewer assigns signs and sees the agreement; a person labels the assigned signs again.
 */

import { errorMessage } from '../api/errors.js';
import { toast } from '../core/toast.js';
import { formatRoute } from '../model/route.js';
import { trackName } from '../model/track_name.js';
import { fill, h, selectInput } from './dom.js';
import { NO_CLASS } from '../model/documents.js';
import { count, percent, plural } from '../model/format.js';
import { imageWithPlaceholder } from './images.js';
import { tableHeading } from './headings.js';

const PICTURE_WIDTH_PX = 320;

/** @typedef {import('../types.js').Agreement} Agreement */

/**
 * The signs assigned to the person who is signed in, one after the other, without the first answer.
 *
 * @param {import('../page-types.js').App} app
 * @param {AbortSignal} signal
 */
export function createSecondOpinionForm(app, signal) {
  const element = h('section.second-opinion', { 'aria-label': 'Second opinion', hidden: true });

  /** @param {string} [problem]   an error to show */
  async function showNext(problem) {
    try {
      const { look, left } = await app.api.nextSecondOpinion({ signal });
      element.hidden = look === null && !element.hasChildNodes();
      fill(
        element,
        ...(look === null
          ? [h('p', { role: 'status' }, 'You have answered for every sign that was assigned to you.')]
          : renderSign(look, left, problem)),
      );
      if (look !== null && problem === undefined) element.querySelector('input')?.focus();
    } catch (thrown) {
      if (signal.aborted) return;
      element.hidden = false;
      fill(element, h('p.field-error', { role: 'alert' }, errorMessage(thrown)));
    }
  }

  /** @param {import('../types.js').Look} look @param {number} left @param {string} [problem] */
  function renderSign(look, left, problem) {
    const [x1, y1, x2, y2] = look.box;
    const alert = h('p.field-error', { role: 'alert' }, problem ?? '');
    const names = h('datalist', { id: 'second-opinion-labels' }, ...look.labels.map(({ name }) => h('option', { value: name })));
    const input = h('input.input', {
      'aria-label': 'Label of the sign',
      placeholder: 'Label',
      list: 'second-opinion-labels',
      autocomplete: 'off',
    });
    /** @param {number|null} label */
    const sendAnswer = async (label) => {
      for (const button of buttons) button.disabled = true; // a second click would answer twice
      try {
        await app.api.answerSecondOpinion(look.id, label, { signal });
        await showNext();
      } catch (thrown) {
        if (!signal.aborted) await showNext(errorMessage(thrown));
      }
    };
    /** @param {Event} event */
    const submit = (event) => {
      event.preventDefault();
      const typed = input.value.trim().toLowerCase();
      const label = look.labels.find(({ name }) => name.toLowerCase() === typed);
      if (label) void sendAnswer(label.id);
      else alert.textContent = 'Choose one of the labels.';
    };
    const buttons = [
      h('button.btn.btn-primary', { type: 'submit' }, 'Confirm'),
      h('button.btn', { onclick: () => void sendAnswer(NO_CLASS) }, 'None of the labels'),
      h('button.btn', { onclick: () => void sendAnswer(null) }, 'No sign'),
    ];
    return [
      h('h2', 'Second opinion ', h('span.muted.small', `${plural(left, 'sign')} left`)),
      h('p.muted.small', 'Somebody has accepted this sign. Say what you see; their answer is not shown.'),
      imageWithPlaceholder({
        class: 'second-opinion-picture',
        alt: 'The sign',
        width: PICTURE_WIDTH_PX,
        src: app.api.searchCropUrl({ run: look.run_id, frame: look.frame, box: [x1, y1, x2, y2] }, PICTURE_WIDTH_PX),
      }),
      h('p.muted.small', { dir: 'auto' }, `${look.video_name}, frame ${look.frame}`),
      h('form.second-opinion-answer', { onsubmit: submit }, input, names, ...buttons),
      alert,
    ];
  }

  void showNext();
  return element;
}

/**
 * The view of a reviewer: agreement, disputed tracks, and a form to assign more.
 *
 * @param {import('../page-types.js').App} app
 * @param {import('../types.js').SecondOpinions} opinions
 * @param {readonly string[]} people   people to whom signs can be assigned
 * @param {AbortSignal} signal
 * @param {() => void} reload
 */
export function createAgreementSection(app, opinions, people, signal, reload) {
  const { whole } = opinions;
  const status = h('p.small', { role: 'status' });
  const person = selectInput(
    { 'aria-label': 'Person' },
    people.map((name) => [name, name]),
  );
  const share = h('input.input', {
    type: 'number',
    min: '0.1',
    max: '100',
    step: '0.1',
    value: '5',
    required: true,
    'aria-label': 'Share of the accepted tracks, %',
  });
  /** @param {Event} event */
  const assignSample = async (event) => {
    event.preventDefault();
    try {
      const { given, accepted, unread } = await app.api.giveSecondOpinions(
        { person: person.value, share: Number(share.value) / 100 },
        { signal },
      );
      if (given > 0) {
        toast(`${plural(given, 'track')} ${given === 1 ? 'is' : 'are'} assigned to ${person.value}.`, { tone: 'good' });
        reload();
      } else
        status.textContent =
          unread > 0
            ? `Nothing was assigned: the tracks of ${plural(unread, 'run')} are still being read. Try again in a moment.`
            : accepted === 0
              ? 'Nobody else has accepted a track yet.'
              : `The sample of ${plural(accepted, 'accepted track')} contains nothing that is not assigned yet.`;
    } catch (thrown) {
      if (!signal.aborted) status.textContent = errorMessage(thrown);
    }
  };
  return h(
    'section',
    { 'aria-label': 'Second opinions' },
    h('h2', 'Second opinions ', h('span.muted.small', `${count(opinions.open)} open`)),
    h(
      'p',
      whole.looked === 0
        ? 'No accepted track has a second opinion yet.'
        : `A second person agrees on ${count(whole.agreed)} of ${plural(whole.looked, 'track')}: ${shareOf(whole)}.`,
    ),
    whole.looked > 0 &&
      h(
        'div.team-people',
        agreementTable(
          ['Looked at', 'Same answer', 'Share, 95 % interval'],
          [
            ...opinions.labels.map((one) => agreementRow(one, 'label')),
            ...opinions.first.map((one) => agreementRow(one, 'accepted by')),
            ...opinions.second.map((one) => agreementRow(one, 'looked at by')),
          ],
        ),
      ),
    boxesOf(opinions.boxes),
    opinions.disputed > 0 && h('h3', `${plural(opinions.disputed, 'track')} in dispute`),
    opinions.disputed > 0 &&
      h(
        'ol.activity',
        { 'aria-label': 'Tracks in dispute' },
        ...opinions.disputes.map((one) =>
          h(
            'li',
            h(
              'a.truncate',
              {
                dir: 'auto',
                href: formatRoute({ screen: 'review', video: one.video_id, run: one.run_id, frame: one.frame, track: one.key }),
              },
              `track ${trackName(one.key)} of ${one.video_name}`,
            ),
            h('span', `${one.first}: ${one.first_answer}. ${one.second}: ${one.second_answer}.`),
          ),
        ),
      ),
    people.length > 0 &&
      h(
        'form.second-opinion-give',
        { onsubmit: assignSample },
        'Give ',
        person,
        ' a sample of ',
        share,
        ' % of the tracks that others have accepted. ',
        h('button.btn', { type: 'submit' }, 'Assign'),
      ),
    status,
  );
}

/** @param {Agreement} one @param {string} what */
const agreementRow = (one, what) => figuresRow(one.name, what, [count(one.looked), count(one.agreed), shareOf(one)]);

/** @param {string} name @param {string} what   what the name is @param {readonly string[]} figures */
const figuresRow = (name, what, figures) =>
  h('tr', h('th', { scope: 'row', dir: 'auto' }, name, ' ', h('span.muted.small', what)), ...figures.map((value) => h('td.number', value)));

/** @param {readonly string[]} figures   names of the columns @param {HTMLElement[]} rows @param {string} [label] */
const agreementTable = (figures, rows, label) =>
  h('table.table.team-table', { 'aria-label': label }, tableHeading(['Of'], figures), h('tbody', ...rows));

/**
 * The overlap of boxes from two people.
 * @param {import('../types.js').SecondOpinions['boxes']} boxes
 */
function boxesOf(boxes) {
  const { whole } = boxes;
  if (whole.tracks === 0) return null;
  /** @param {typeof whole} one */
  const mean = ({ iou, low, high }) => `${iou.toFixed(2)} (${low.toFixed(2)} to ${high.toFixed(2)})`;
  /** @param {typeof whole} one @param {string} what */
  const row = (one, what) => figuresRow(one.name, what, [count(one.tracks), count(one.frames), mean(one)]);
  return h(
    'div.team-people',
    h('p', `Where two people have drawn a box of ${plural(whole.tracks, 'track')}, the mean IoU is ${mean(whole)}.`),
    agreementTable(
      ['Tracks', 'Frames', 'Mean IoU, 95 % interval'],
      [
        ...boxes.labels.map((one) => row(one, 'label')),
        ...boxes.first.map((one) => row(one, 'drawn by')),
        ...boxes.second.map((one) => row(one, 'drawn anew by')),
      ],
      'Boxes of two people',
    ),
  );
}

/** @param {Agreement} one */
const shareOf = ({ looked, agreed, low, high }) => `${percent(agreed / looked)} (${percent(low)} to ${percent(high)})`;

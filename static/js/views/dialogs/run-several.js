// @ts-check
/** Start a run on each of several videos with the same settings. */

import { sentence } from '../../api/errors.js';
import { processAll } from '../../model/several_videos.js';
import { putRun } from '../../store/actions/page.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';
import { toast } from '../../core/toast.js';
import { createRunForm } from './run-form.js';

/**
 * @param {import('./layer.js').Setup<'run-several'>} setup
 * @returns {import('./layer.js').Content}
 */
export function runSeveralDialog(setup) {
  const { app, data, signal, close } = setup;
  /** @type {readonly import('../../types.js').Video[]} */
  const videos = data.videos;
  const progress = h('p.muted', { role: 'status' });

  /** @param {import('../../api/runs.js').RunRequest} order */
  async function send(order) {
    let asked = 0;
    const { done, errors } = await processAll(
      videos,
      (video) => {
        asked += 1;
        setText(progress, `Run ${count(asked)} of ${count(videos.length)} is being started …`);
        return app.load(() => app.api.startRun(video.id, order, { signal }), putRun);
      },
      sentence,
    );
    setText(progress, '');
    if (done.length) toast(`${plural(done.length, 'run')} ${done.length === 1 ? 'is' : 'are'} started.`, { tone: 'good' });
    data.done?.(done.map(({ video_id }) => video_id));
    if (signal.aborted) return '';
    if (done.length === 0) return errors[0] ?? '';
    if (errors.length) toast(errorWords(errors), { tone: 'bad' });
    close();
    return '';
  }

  const form = createRunForm(setup, { frames: null, several: true, words: 'Start the runs', send });
  return {
    title: `Run the engine on ${plural(videos.length, 'video')}`,
    size: 'middle',
    body: h(
      'div.stack',
      h('p', 'Each video gets a run with this preset and these parameters. The runs are queued; “Run queue” changes their order.'),
      form.element,
      progress,
    ),
    footer: form.footer,
    submit: form.submit,
    focus: form.focus,
  };
}

/** Maximum number of sentences in one notice. */
const TOLD = 3;

/** @param {readonly string[]} errors */
function errorWords(errors) {
  const different = [...new Set(errors)];
  const rest = different.length - TOLD;
  return [...different.slice(0, TOLD), ...(rest > 0 ? [`And ${plural(rest, 'other problem')}.`] : [])].join(' ');
}

// @ts-check
/** Open somebody else's bug bundle: its clip, run and corrections are added to the library. */

import { errorMessage } from '../../api/errors.js';
import { formatRoute } from '../../model/route.js';
import { putRun, putVideo } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { bytes, count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { authorName } from '../../core/preferences.js';
import { createDropField } from './drop_field.js';
import { reportClosed } from './import_progress.js';
import { tableHeading } from '../headings.js';

/** @type {import('./index.js').CreateDialog<'import-bundle'>} */
export function importBundleDialog({ app, data, close, signal }) {
  let isImporting = false;
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit', disabled: true }, icon('add'), 'Open');
  const fileField = createDropField({
    id: 'bundle-file',
    label: 'Bug bundle',
    accept: '.zip',
    hint: 'A ZIP file from “Report a bug” or tsr bundle. It is checked before it is used.',
    onChange: () => {
      setText(errorText, '');
      submitButton.disabled = isImporting;
    },
  });
  const result = h('div.stack', { hidden: true });

  async function submit() {
    const file = fileField.file();
    if (!file || submitButton.disabled) return;
    submitButton.disabled = isImporting = true;
    try {
      const { video, run, report } = await app.load(
        () =>
          app.api.importBundle(file, authorName(app.store.get().session), {
            signal,
            onProgress: (sent, total) =>
              setText(errorText, sent < total ? `${bytes(sent)} of ${bytes(total)} sent` : 'The server checks the bundle …'),
          }),
        (state, imported) => putRun(putVideo(state, imported.video), imported.run),
      );
      setText(errorText, '');
      submitButton.hidden = true;
      fileField.element.hidden = true;
      result.hidden = false;
      fill(
        result,
        h(
          'p.import-done',
          { role: 'status' },
          icon('check'),
          h('strong', `${video.name} is in the library. Its frames are decoded once before they can be shown.`),
        ),
        report.note && h('blockquote.note-quote', report.note),
        h(
          'p.muted.small',
          `Frames ${count(report.first + report.offset)} to ${count(report.stop - 1 + report.offset)} of ${report.video_name}${report.offset ? `, ${count(report.first)} to ${count(report.stop - 1)} of this clip` : ''}; ${plural(report.corrections, 'correction')}; made with tsr ${report.engine_version}.`,
        ),
        report.other_pictures > 0 &&
          h(
            'p.field-hint',
            `${plural(report.other_pictures, 'picture decodes', 'pictures decode')} to other values here than on the original machine, so expect small differences.`,
          ),
        report.expected.length > 0 &&
          h(
            'table.table',
            tableHeading(['Expected', 'When it was made']),
            h('tbody', ...report.expected.map((one) => h('tr', h('td', one.expected), h('td', one.met ? '✓ ' : '✗ ', one.got)))),
          ),
        report.skipped.length > 0 && h('ul.skipped-list.small', ...report.skipped.map((text) => h('li', text))),
        h(
          'div.row',
          h(
            'a.btn.btn-primary',
            {
              href: formatRoute({ screen: 'review', video: video.id, run: run.id, frame: report.frame, track: report.track }),
              onclick: close,
            },
            icon('eye'),
            'Review it',
          ),
        ),
      );
      result.querySelector('a')?.focus();
    } catch (thrown) {
      if (signal.aborted) {
        reportClosed(file.name);
        return;
      }
      setText(errorText, errorMessage(thrown));
      submitButton.disabled = isImporting = false;
    }
  }

  if (data.file) fileField.set(data.file);
  return {
    title: 'Open a bug bundle',
    size: 'middle',
    submit,
    focus: fileField.button,
    body: h('div.stack', fileField.element, result),
    footer: [errorText, h('button.btn', { onclick: close }, 'Close'), submitButton],
  };
}

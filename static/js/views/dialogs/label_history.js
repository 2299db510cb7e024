// @ts-check
/** The versions of a label set: author, time and changes; each change can be undone. */

import { errorMessage } from '../../api/errors.js';
import { fill, h, setText } from '../dom.js';
import { moment } from '../../model/format.js';
import { icon } from '../icons.js';

/** @type {import('./index.js').CreateDialog<'label-history'>} */
export function labelHistoryDialog({ app, data, close, signal }) {
  const list = h('ol.made-list', { 'aria-label': 'Versions, newest first' });
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const status = h('p.muted', { role: 'status' }, 'Loading the versions …');

  async function load() {
    try {
      const versions = await api.labelHistory(data.set, { signal });
      const undone = new Set(versions.map(({ undoes }) => undoes));
      setText(status, '');
      fill(
        list,
        ...versions.map((version) =>
          h(
            'li.made',
            h(
              'div.stack.made-text',
              h('span', { dir: 'auto' }, version.sentence),
              h(
                'span.muted.small',
                // the first change stores the shipped version too, at that time and without an author
                version.created === null || version.author === ''
                  ? `Version ${version.version}, as shipped with tsr`
                  : `Version ${version.version} · ${version.author} · ${moment(version.created)}`,
              ),
            ),
            h(
              'div.row.made-actions',
              undone.has(version.version)
                ? h('span.badge', 'taken back')
                : version.version > 1 &&
                    h(
                      'button.btn.btn-small',
                      { 'aria-label': `Undo version ${version.version}`, onclick: () => void undo(version.version) },
                      icon('undo'),
                      'Undo',
                    ),
            ),
          ),
        ),
      );
    } catch (thrown) {
      if (!signal.aborted) setText(status, errorMessage(thrown));
    }
  }

  /** @param {number} version */
  async function undo(version) {
    setText(errorText, '');
    try {
      const { sentence: message } = await app.labels.change({ type: 'undo', version }, data.set);
      await load();
      setText(status, message);
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    }
  }

  const { api } = app;
  void load();
  return {
    title: 'History of the label set',
    size: 'middle',
    body: h('div.stack', status, list),
    footer: [errorText, h('button.btn', { onclick: close }, 'Close')],
  };
}

// @ts-check
/** The versions of a label set: author, time and changes; each change can be undone. */

import { sentence } from '../../api/errors.js';
import { fill, h, setText } from '../dom.js';
import { moment } from '../../model/format.js';
import { icon } from '../icons.js';

/**
 * @param {import('./index.js').DialogSetup<'label-history'>} setup
 * @returns {import('./index.js').DialogContent}
 */
export function labelHistoryDialog({ app, data, close, signal }) {
  const list = h('ol.made-list', { 'aria-label': 'Versions, newest first' });
  const error = h('p.field-error.grow', { role: 'alert' });
  const status = h('p.muted', { role: 'status' }, 'Loading the versions …');

  async function load() {
    try {
      const versions = await api.labelHistory(data.set, { signal });
      const undone = new Set(versions.map(({ undoes }) => undoes));
      setText(status, '');
      fill(
        list,
        ...versions.map((one) =>
          h(
            'li.made',
            h(
              'div.stack.made-text',
              h('span', { dir: 'auto' }, one.sentence),
              h(
                'span.muted.small',
                one.created === null
                  ? `Version ${one.version}, as shipped with tsr`
                  : `Version ${one.version} · ${one.author} · ${moment(one.created)}`,
              ),
            ),
            h(
              'div.row.made-actions',
              undone.has(one.version)
                ? h('span.badge', 'taken back')
                : one.version > 1 &&
                    h(
                      'button.btn.btn-small',
                      { 'aria-label': `Undo version ${one.version}`, onclick: () => void undo(one.version) },
                      icon('undo'),
                      'Undo',
                    ),
            ),
          ),
        ),
      );
    } catch (thrown) {
      if (!signal.aborted) setText(status, sentence(thrown));
    }
  }

  /** @param {number} version */
  async function undo(version) {
    setText(error, '');
    try {
      const { sentence: said } = await app.labels.change({ type: 'undo', version }, data.set);
      await load();
      setText(status, said);
    } catch (thrown) {
      if (!signal.aborted) setText(error, sentence(thrown));
    }
  }

  const { api } = app;
  void load();
  return {
    title: 'History of the label set',
    size: 'middle',
    body: h('div.stack', status, list),
    footer: [error, h('button.btn', { onclick: close }, 'Close')],
  };
}

// @ts-check
/** Add videos from the server's machine: browse folders, or type a path. */

import { sentence } from '../../api/errors.js';
import { addedMessage, processAll, togglePath } from '../../model/several_videos.js';
import { putVideo } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { waiting } from '../empty.js';
import { bytes, count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { toast } from '../../core/toast.js';

/**
 * @param {import('./layer.js').Setup<'add-video'>} setup
 * @returns {import('./layer.js').Content}
 */
export function addVideoDialog({ app, close, signal }) {
  /** Paths of the chosen videos in this folder. @type {readonly string[]} */
  let chosen = [];
  /** Paths of all videos in this folder. @type {readonly string[]} */
  let present = [];
  let place = '';
  const path = h('input.input.grow', {
    type: 'text',
    id: 'add-path',
    autocomplete: 'off',
    spellcheck: 'false',
    'aria-describedby': 'add-error add-hint',
    oninput: () => choose([], path.value),
  });
  const error = h('p.field-error', { id: 'add-error', role: 'alert', hidden: true });
  const list = h('div.browser', { 'aria-label': 'Folders and videos', role: 'group' });
  const add = h('button.btn.btn-primary', { type: 'submit' }, 'Add');
  const roots = app.store.get().session?.roots ?? [];
  const all = h('button.btn.btn-small', { hidden: true, onclick: () => choose(chosen.length === present.length ? [] : present) });
  const places = h(
    'div.row.browser-roots',
    ...roots.map((root) => h('button.btn.btn-small', { title: root, onclick: () => open(root) }, icon('folder'), lastName(root))),
    h('span.grow'),
    all,
  );

  /** @param {unknown} thrown */
  function fail(thrown) {
    error.hidden = false;
    setText(error, sentence(thrown));
  }

  /** @param {readonly string[]} paths @param {string} [typed]   text of the field instead of the paths */
  function choose(paths, typed) {
    chosen = paths;
    error.hidden = true;
    const named = typed ?? (chosen.length === 1 ? chosen[0] : place);
    if (path.value !== named) path.value = named;
    setText(add, chosen.length > 1 ? `Add ${plural(chosen.length, 'video')}` : 'Add');
    all.hidden = present.length < 2;
    setText(all, chosen.length === present.length ? 'Choose none' : `Choose all ${count(present.length)}`);
    for (const other of list.querySelectorAll('[data-path]')) {
      other.setAttribute('aria-pressed', String(chosen.includes(other instanceof HTMLElement ? (other.dataset.path ?? '') : '')));
    }
  }

  /** @param {string|null} where */
  async function open(where) {
    present = [];
    choose([]);
    list.replaceChildren(waiting('Reading the folder', { signal, retry: () => open(where) }));
    try {
      const folder = await app.api.browse(where, { signal });
      place = folder.path;
      present = folder.videos.map((video) => video.path);
      const { parent } = folder;
      fill(
        list,
        parent !== null && row('up', '..', 'One folder up', () => open(parent)),
        folder.truncated && h('p.muted.browser-none', lacking(folder)),
        folder.folders.map((name) =>
          row('folder', lastName(name), name, () => open(name.startsWith('/') ? name : join(folder.path, name))),
        ),
        folder.videos.map((video) => row('film', video.name, bytes(video.size), () => choose(togglePath(chosen, video.path)), video.path)),
        folder.videos.length === 0 &&
          !folder.truncated &&
          h('p.muted.browser-none', folder.folders.length ? 'No video in this folder.' : 'This folder is empty: no video, no folder.'),
      );
      choose([]);
    } catch (thrown) {
      if (signal.aborted) return;
      fill(list);
      fail(thrown);
    }
  }

  async function submit() {
    const wanted = chosen.length ? chosen : [path.value.trim()];
    if (!wanted[0]) {
      error.hidden = false;
      setText(error, 'Choose a video, or type its path.');
      return;
    }
    add.disabled = true;
    error.hidden = true;
    const { done, left, errors } = await processAll(
      wanted,
      (one) => {
        if (wanted.length > 1) setText(add, `Adding ${count(wanted.indexOf(one) + 1)} of ${count(wanted.length)} …`);
        return app.load(() => app.api.addVideo(one, { signal }), putVideo);
      },
      sentence,
    );
    add.disabled = false;
    if (done.length) toast(addedMessage(done));
    if (signal.aborted) return;
    if (left.length === 0) {
      close();
      return;
    }
    choose(chosen.length ? left : [], chosen.length ? undefined : path.value);
    error.hidden = false;
    setText(error, errors.join(' '));
  }

  // Enter chooses a video; pressed again, it adds the chosen ones
  list.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter' || !(event.target instanceof HTMLElement) || event.target.ariaPressed !== 'true') return;
    event.preventDefault();
    void submit();
  });
  void open(null);
  return {
    title: 'Add videos from a folder',
    size: 'middle',
    submit,
    focus: path,
    body: h(
      'div.stack',
      h(
        'div.field',
        h('label.field-label', { for: 'add-path' }, 'Path'),
        path,
        h(
          'span.field-hint',
          { id: 'add-hint' },
          'Choose one or several below, or type a path. Files are not moved. Videos can be added from these folders:',
        ),
      ),
      places,
      list,
      error,
    ),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Cancel'), add],
  };
}

/**
 * @param {import('../icons.js').IconName} name
 * @param {string} text
 * @param {string} detail
 * @param {() => void} act
 * @param {string} [video]   its path
 */
function row(name, text, detail, act, video) {
  return h(
    'button.browser-row',
    { title: detail, onclick: act, 'aria-pressed': video ? 'false' : null, dataset: video ? { path: video } : {} },
    icon(name),
    h('span.truncate.grow', text),
    video && h('span.muted.small', detail),
  );
}

/**
 * The message for a folder with more entries than are listed.
 * @param {Pick<import('../../api/videos.js').Folder, 'folders'|'videos'>} folder
 */
export function lacking({ folders, videos }) {
  return `Only the first ${plural(folders.length + videos.length, 'folder or video', 'folders and videos')} by name are listed. Type the path of another one above.`;
}

/** @param {string} path */
function lastName(path) {
  return path.split('/').filter(Boolean).pop() ?? path;
}

/** @param {string} folder @param {string} name */
function join(folder, name) {
  return `${folder.replace(/\/$/, '')}/${name}`;
}

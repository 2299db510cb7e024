// @ts-check
/** Add a video that lies on the server's machine: folders to walk through, or a path to type. */

import {sentence} from '../../api/errors.js';
import {putVideo} from '../../store/actions/page.js';
import {fill, h, setText} from '../dom.js';
import {waiting} from '../empty.js';
import {bytes, count} from '../format.js';
import {icon} from '../icons.js';
import {toast} from '../toasts.js';

/**
 * @param {import('./layer.js').Setup} setup
 * @returns {import('./layer.js').Content}
 */
export function addVideoDialog({app, close, signal}) {
  const path = h('input', {class: 'input grow', type: 'text', id: 'add-path', autocomplete: 'off', spellcheck: 'false', 'aria-describedby': 'add-error add-hint'});
  const error = h('p', {class: 'field-error', id: 'add-error', role: 'alert', hidden: true});
  const list = h('div', {class: 'browser', 'aria-label': 'Folders and videos', role: 'group'});
  const add = h('button', {class: 'btn btn-primary', type: 'submit'}, 'Add');
  const roots = app.store.get().session?.roots ?? [];
  const places = h('div', {class: 'row browser-roots'}, ...roots.map((root) => h('button', {class: 'btn btn-small', type: 'button', title: root, onclick: () => open(root)}, icon('folder'), lastName(root))));

  /** @param {unknown} thrown */
  function fail(thrown) {
    error.hidden = false;
    setText(error, sentence(thrown));
  }

  /** @param {string|null} place */
  async function open(place) {
    error.hidden = true;
    list.replaceChildren(waiting('The folder is read', {signal, retry: () => open(place)}));
    try {
      const folder = await app.api.browse(place, {signal});
      path.value = folder.path;
      const {parent} = folder;
      fill(list,
        parent !== null && row('up', '..', 'One folder up', () => open(parent)),
        folder.truncated && h('p', {class: 'muted browser-none'}, lacking(folder)),
        folder.folders.map((name) => row('folder', lastName(name), name, () => open(name.startsWith('/') ? name : join(folder.path, name)))),
        folder.videos.map((video) => row('film', video.name, bytes(video.size), () => {
          path.value = video.path;
          for (const other of list.querySelectorAll('[aria-pressed]')) other.setAttribute('aria-pressed', 'false');
          list.querySelector(`[data-path="${CSS.escape(video.path)}"]`)?.setAttribute('aria-pressed', 'true');
          add.focus();
        }, video.path)),
        folder.videos.length === 0 && !folder.truncated && h('p', {class: 'muted browser-none'}, folder.folders.length ? 'No video in this folder.' : 'This folder is empty: no video, no folder.'));
    } catch (thrown) {
      if (signal.aborted) return;
      fill(list);
      fail(thrown);
    }
  }

  async function submit() {
    const value = path.value.trim();
    if (!value) {
      fail(null);
      setText(error, 'Choose a video, or type its path.');
      return;
    }
    add.disabled = true;
    error.hidden = true;
    try {
      const video = await app.load(() => app.api.addVideo(value, {signal}), putVideo);
      toast(`${video.name} is ${video.state === 'importing' ? 'being imported' : 'in the library'}.`);
      close();
    } catch (thrown) {
      if (!signal.aborted) fail(thrown);
    } finally {
      add.disabled = false;
    }
  }

  void open(null);
  return {
    title: 'Add a video from a folder', size: 'middle', submit, focus: path,
    body: h('div', {class: 'stack'},
      h('div', {class: 'field'}, h('label', {class: 'field-label', for: 'add-path'}, 'Path'), path,
        h('span', {class: 'field-hint', id: 'add-hint'}, 'The file stays where it is. Videos can be added from these folders:')),
      places, list, error),
    footer: [h('span', {class: 'grow'}), h('button', {class: 'btn', type: 'button', onclick: close}, 'Cancel'), add],
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
  return h('button', {class: 'browser-row', type: 'button', title: detail, onclick: act, 'aria-pressed': video ? 'false' : null, dataset: video ? {path: video} : {}},
    icon(name), h('span', {class: 'truncate grow'}, text), video && h('span', {class: 'muted small'}, detail));
}

/**
 * What is said of a folder that holds more than is listed.
 * @param {Pick<import('../../api/client.js').Folder, 'folders'|'videos'>} folder
 */
export function lacking({folders, videos}) {
  return `This folder holds more: the first ${count(folders.length + videos.length)} folders and videos by name are listed. Type the path of any other one above.`;
}

/** @param {string} path */
function lastName(path) {
  return path.split('/').filter(Boolean).pop() ?? path;
}

/** @param {string} folder @param {string} name */
function join(folder, name) {
  return `${folder.replace(/\/$/, '')}/${name}`;
}

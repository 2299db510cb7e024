// @ts-check
/**
 * Operations that the server has not acknowledged yet, kept in the browser's database: a reload, a crash of the browser
 * or a dead server loses none of them. Each is written at once, but not forced to the disk: that takes so long that a
 * reload overtook those that were waiting. What the machine's power takes along is what neither server nor disk had yet.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {object} Pending
 * @property {string} op_id
 * @property {string} run
 * @property {string} author
 * @property {Command|{name: 'undo'|'redo', op_id: string}} command
 * @property {number} order
 * @property {Record<string, number>} seen   revision of each touched track that the person saw
 *
 * @typedef {object} Outbox
 * @property {(run: string) => Promise<Pending[]>} load   of one run, in order
 * @property {(pending: Pending) => Promise<void>} put
 * @property {(op_id: string) => Promise<void>} remove
 */

const NAME = 'tsr-review';
const STORE = 'outbox';

/**
 * @param {IDBFactory} [factory]
 * @returns {Outbox}
 */
export function createOutbox(factory = globalThis.indexedDB) {
  /** @type {Promise<IDBDatabase>|null} */
  let opened = null;
  const database = () => (opened ??= open(factory));

  /**
   * @template T
   * @param {IDBTransactionMode} mode
   * @param {(store: IDBObjectStore) => IDBRequest<T>} act
   * @returns {Promise<T>}
   */
  async function within(mode, act) {
    const db = await database();
    return new Promise((resolve, reject) => {
      const transaction = db.transaction(STORE, mode, { durability: 'relaxed' });
      const request = act(transaction.objectStore(STORE));
      transaction.commit(); // not only when the page comes round to it: it may be about to go
      transaction.oncomplete = () => resolve(request.result);
      transaction.onabort = () => reject(transaction.error);
    });
  }

  return {
    async load(run) {
      const all = /** @type {Pending[]} */ (await within('readonly', (store) => store.getAll()));
      return all.filter((pending) => pending.run === run).sort((a, b) => a.order - b.order);
    },
    put: async (pending) => void (await within('readwrite', (store) => store.put(pending))),
    remove: async (op_id) => void (await within('readwrite', (store) => store.delete(op_id))),
  };
}

/** An outbox in memory, where the browser has no database (private windows of some) and in tests. @returns {Outbox} */
export function createMemoryOutbox() {
  /** @type {Map<string, Pending>} */
  const held = new Map();
  return {
    load: async (run) => [...held.values()].filter((pending) => pending.run === run).sort((a, b) => a.order - b.order),
    put: async (pending) => void held.set(pending.op_id, pending),
    remove: async (op_id) => void held.delete(op_id),
  };
}

/**
 * @param {IDBFactory} factory
 * @returns {Promise<IDBDatabase>}
 */
function open(factory) {
  return new Promise((resolve, reject) => {
    const request = factory.open(NAME, 1);
    request.onupgradeneeded = () => request.result.createObjectStore(STORE, { keyPath: 'op_id' });
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
    request.onblocked = () => reject(new Error('Another page holds an older version of the outbox.'));
  });
}

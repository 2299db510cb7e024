// @ts-check
/**
 * Operations that the server has not acknowledged, kept in the browser's database: they survive a reload, a crash of
 * the browser and a failed server. Each is written at once, but without a flush to the disk: flushing is so slow that a
 * reload could overtake the writes that were waiting. A power failure can therefore lose operations that neither the
 * server nor the disk has yet.
 *
 * Operations are sent in the order in which they were first put. The database numbers them across visits: a clock can
 * be set back, and an edit would then be sent before the edit that it builds on.
 *
 * A change of an operation replaces its row. If the database has not told the number of that row yet, the change gets a
 * row of its own: the page may end before the number is known. So an operation has the place of its first row and the
 * content of its last.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {object} Pending
 * @property {string} op_id
 * @property {string} run
 * @property {string} author
 * @property {Command|{name: 'undo'|'redo', op_id: string}} command   op_id empty: the server says which operation is meant when this one is sent
 * @property {Record<string, number>} seen   revision that the person saw, of each track that the command touches
 * @property {import('../types.js').UndoTarget} [about]   the operation that an undo or redo is about
 * @property {boolean} [growing]   a box that is being moved by keys; it is sent when no key is pressed for a while
 *
 * @typedef {object} Row
 * @property {number|undefined} order   its number; undefined: the database has not told it yet
 * @property {Promise<number>} written
 *
 * @typedef {object} Outbox
 * @property {() => Promise<Pending[]>} all               of all runs, in order
 * @property {(run: string) => Promise<Pending[]>} load   of one run, in order
 * @property {(pending: Pending) => Promise<void>} put    an operation that is already stored keeps its place
 * @property {(op_id: string) => Promise<void>} remove
 */

const DATABASE_NAME = 'tsr-review';
const DATABASE_VERSION = 2;
const STORE_NAME = 'pending';
/** The store of version 1, which sorted by the clock. */
const OLD_STORE_NAME = 'outbox';

/** @param {IDBFactory} [factory] @returns {Outbox} */
export function createOutbox(factory = globalThis.indexedDB) {
  /** @type {Promise<IDBDatabase>|null} */
  let opened = null;
  /** Rows of each operation in the database, oldest first. @type {Map<string, Row[]>} */
  const rows = new Map();

  /** A database that failed or was closed is opened again by the next access. */
  const resetConnection = () => (opened = null);

  function database() {
    if (opened === null) {
      opened = open(factory, resetConnection);
      opened.catch(resetConnection);
    }
    return opened;
  }

  /**
   * @template T
   * @param {IDBTransactionMode} mode
   * @param {(store: IDBObjectStore) => IDBRequest<T>} makeRequest
   * @returns {Promise<T>}
   */
  async function runTransaction(mode, makeRequest) {
    const db = await database();
    return new Promise((resolve, reject) => {
      const transaction = db.transaction(STORE_NAME, mode, { durability: 'relaxed' });
      const request = makeRequest(transaction.objectStore(STORE_NAME));
      transaction.commit(); // at once, because the page may be about to close
      transaction.oncomplete = () => resolve(request.result);
      transaction.onabort = () => reject(transaction.error);
    });
  }

  /** @param {Pending} pending @param {number} [order] @returns {Promise<number>} the row's number */
  async function write(pending, order) {
    const key = await runTransaction('readwrite', (store) => store.put(order === undefined ? pending : { ...pending, order }));
    return /** @type {number} */ (key);
  }

  async function all() {
    const read = /** @type {(Pending & {order: number})[]} */ (await runTransaction('readonly', (store) => store.getAll()));
    /** @type {Map<string, Pending>} */
    const operations = new Map();
    /** @type {Map<string, Row[]>} */
    const known = new Map();
    for (const { order, ...pending } of read) {
      operations.set(pending.op_id, pending); // in the order of the first rows
      known.set(pending.op_id, [...(known.get(pending.op_id) ?? []), { order, written: Promise.resolve(order) }]);
    }
    for (const [op_id, found] of known) {
      const unread = (rows.get(op_id) ?? []).filter(({ order }) => order === undefined);
      rows.set(op_id, [...found, ...unread]);
    }
    return [...operations.values()];
  }

  return {
    all,
    load: async (run) => (await all()).filter((one) => one.run === run),
    async put(pending) {
      const { op_id } = pending;
      const ofOperation = rows.get(op_id) ?? [];
      const order = ofOperation.at(-1)?.order;
      const written = write(pending, order);
      if (order === undefined) {
        /** @type {Row} */
        const row = { order, written };
        rows.set(op_id, [...ofOperation, row]);
        written.then(
          (number) => (row.order = number),
          () => {
            const left = rows.get(op_id)?.filter((one) => one !== row);
            if (left) rows.set(op_id, left);
          },
        );
      }
      await written;
    },
    async remove(op_id) {
      const removed = rows.get(op_id) ?? [];
      rows.delete(op_id);
      const numbers = (await Promise.allSettled(removed.map(({ written }) => written))).flatMap((one) =>
        one.status === 'fulfilled' ? [one.value] : [],
      );
      if (numbers.length) await runTransaction('readwrite', (store) => numbers.map((number) => store.delete(number))[0]);
    },
  };
}

/** An outbox in memory, for tests and for browsers without a database (some private windows). @returns {Outbox} */
export function createMemoryOutbox() {
  /** In the order of the first `put`. @type {Map<string, Pending>} */
  const operations = new Map();
  return {
    all: async () => [...operations.values()],
    load: async (run) => [...operations.values()].filter((pending) => pending.run === run),
    put: async (pending) => void operations.set(pending.op_id, pending),
    remove: async (op_id) => void operations.delete(op_id),
  };
}

/**
 * @param {IDBFactory} factory
 * @param {() => void} onClosed   called when the database was closed: by the browser, or for a page of a newer version
 * @returns {Promise<IDBDatabase>}
 */
function open(factory, onClosed) {
  return new Promise((resolve, reject) => {
    const request = factory.open(DATABASE_NAME, DATABASE_VERSION);
    let wasBlocked = false;
    request.onupgradeneeded = ({ oldVersion }) => {
      const db = request.result;
      const store = db.createObjectStore(STORE_NAME, { keyPath: 'order', autoIncrement: true });
      if (oldVersion === 1) migrateVersion1(db, /** @type {IDBTransaction} */ (request.transaction).objectStore(OLD_STORE_NAME), store);
    };
    request.onsuccess = () => {
      const db = request.result;
      if (wasBlocked) {
        db.close();
        return;
      }
      db.onversionchange = () => {
        db.close();
        onClosed();
      };
      db.onclose = onClosed;
      resolve(db);
    };
    request.onerror = () => reject(request.error);
    request.onblocked = () => {
      wasBlocked = true;
      reject(new Error('Another page holds an older version of the outbox. Close it.'));
    };
  });
}

/**
 * Move everything from the store of version 1 in one transaction: if one operation cannot be moved, nothing changes.
 * @param {IDBDatabase} db
 * @param {IDBObjectStore} before
 * @param {IDBObjectStore} store
 */
function migrateVersion1(db, before, store) {
  const all = /** @type {IDBRequest<(Pending & {order: number})[]>} */ (before.getAll());
  all.onsuccess = () => {
    for (const { order: _time, ...pending } of all.result.sort((a, b) => a.order - b.order)) store.add(pending);
    db.deleteObjectStore(OLD_STORE_NAME);
  };
}

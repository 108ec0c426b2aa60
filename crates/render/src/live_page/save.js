// @ts-check
// Saving and sharing: the address, a picture, the mask, the command line, the digest.

const saveDialog = byId("save-dialog", HTMLDialogElement);
const toast = htmlById("toast");
/** @type {ReturnType<typeof setTimeout> | undefined} */
let toastTimer;

/** How long a word is shown, and one that is long or offers something to do [ms]. */
const TOAST = { short: 2000, long: 5000 };
/** Words that take longer to read than `TOAST.short`. */
const LONG_WORDS = 30;

/**
 * Shows a word for a while, with something to do about it.
 * @param {string} text
 * @param {{action: string, does: () => void} | null} [offer]
 */
function notify(text, offer = null) {
  // An open dialog covers all that is not in it.
  const home = saveDialog.open ? saveDialog : document.body;
  if (toast.parentElement !== home) home.append(toast);
  setText(htmlById("toast-words"), text);
  const action = buttonById("toast-action");
  action.hidden = !offer;
  setText(action, offer?.action ?? "");
  action.onclick = () => {
    hideToast();
    offer?.does();
  };
  toast.classList.add("shown");
  clearTimeout(toastTimer);
  toastTimer = setTimeout(hideToast, offer || text.length > LONG_WORDS ? TOAST.long : TOAST.short);
}

function hideToast() {
  clearTimeout(toastTimer);
  toast.classList.remove("shown");
}

/**
 * Copies a text; where the browser refuses, it stands selected in the dialog.
 * @param {string} text
 * @param {string} [done] what is said then
 */
async function copyText(text, done = say().copied) {
  try {
    await navigator.clipboard.writeText(text);
    notify(done);
    return;
  } catch {
    // Refused, or not there: try the old way.
  }
  const field = make("textarea", { class: "offscreen", "aria-hidden": "true" });
  field.value = text;
  (saveDialog.open ? saveDialog : document.body).append(field);
  field.select();
  const isCopied = document.execCommand("copy");
  field.remove();
  if (isCopied) {
    notify(done);
    return;
  }
  openSave();
  inputById("address").select();
  notify(say().notCopied);
}

/** Copies the address, and says that one of a file is of use only where the file is. */
const copyAddress = () => copyText(addressToCopy(), location.protocol === "file:" ? say().copiedLocal : say().copied);

/** Brings what the dialog shows up to date. */
function showSave() {
  const words = say();
  const uavs = uavsOnMap();
  const left = shown().layer === "one" ? [] : state.uavs.filter((uav) => !uavs.includes(uav));
  // What is a part of a raster is not what the command maps.
  const same = facts.is_part ? words.partSays : words.commandSays;
  const leftOut = left.length > 0 ? ` ${words.leftOut(left.map(uavName).join(", "))}` : "";
  setText(htmlById("command-says"), uavs.length > 0 ? same + leftOut : words.noMap);
  setText(htmlById("digest-says"), facts.is_part ? words.partSays : coverage.digest ? words.digestSays : "");
  inputById("address").value = addressToCopy();
  setText(htmlById("link-note"), location.protocol === "file:" ? say().linkLocal : say().linkSays);
  // Lines break before options, not at their hyphens.
  const parts = commandWords().join(" ").split(/ (?=-)/);
  htmlById("command").replaceChildren(...parts.flatMap((part, k) => [...(k > 0 ? [" "] : []), make("span", {}, part)]));
  buttonById("copy-command").disabled = uavs.length === 0;
  buttonById("copy-digest").disabled = coverage.digest === null;
  setText(htmlById("digest"), coverage.digest ?? (uavs.length === 0 || left.length > 0 ? words.digestNone : words.digestLater));
  const select = selectById("mask-of");
  const options = state.uavs.map((uav, k) => new Option(uavName(uav), String(k)));
  if (state.uavs.length > 1) options.unshift(new Option(say().maskAny, ""));
  const { value } = select;
  select.replaceChildren(...options);
  if (options.some((option) => option.value === value)) select.value = value;
  else if (state.uavs.length > 1 && state.layer === "one") select.value = String(state.selected);
}

function openSave() {
  showSave();
  if (!saveDialog.open) saveDialog.showModal();
}

/** The mask of a UAV, or of all. @param {number | null} which @returns {Promise<Uint8Array<ArrayBuffer>>} */
async function askMask(which) {
  const { mask } = await ask({ do: "mask", which });
  return new Uint8Array(mask);
}

/** The mask that the dialog names. */
function chosenMask() {
  const { value } = selectById("mask-of");
  return askMask(value === "" ? null : Number(value));
}

/** Counts the cells of the rows that are no receivers. @param {LegendRow[]} rows @param {Uint8Array} mask @returns {LegendRow[]} */
function withCells(rows, mask) {
  const tone = engine.opened ? new Uint8Array(engine.opened.tone) : mask;
  let [buildings, ground, away, none] = [0, 0, 0, 0];
  for (let i = 0; i < mask.length; i += 1) {
    if (mask[i] === 2 && tone[i] >= 128) buildings += 1;
    else if (mask[i] === 2) ground += 1;
    else if (mask[i] === 3) away += 1;
    else if (mask[i] === 255) none += 1;
  }
  const cells = { buildings, ground, away, hatched: none };
  return rows.map((row) => (row.fill ? { ...row, cells: cells[row.fill] } : row)).filter((row) => row.cells !== 0);
}

async function savePicture() {
  await idle();
  const { answer } = coverage;
  if (!answer) return;
  const { layer, which } = shown();
  const mask = await askMask(layer === "one" ? which : null);
  const part = inputById("picture-view").checked ? "view" : "whole";
  const rows = withCells([...receiverRows(answer), ...otherRows()], mask);
  const canvas = drawPicture(part, answer, rows);
  frame.drawSoon();
  saveFile(`${fileStem()}-${part === "whole" ? "coverage" : "view"}.png`, "image/png", [await canvasBlob(canvas)]);
}

async function saveTiff() {
  await idle();
  saveFile(`${fileStem()}-mask.tif`, "image/tiff", await geotiff(await chosenMask()));
}

async function saveWorld() {
  await idle();
  const png = await maskPng(await chosenMask());
  const text = (/** @type {string} */ words) => new TextEncoder().encode(words);
  const stem = `${fileStem()}-mask`;
  /** @type {[string, Uint8Array<ArrayBuffer>][]} */
  const files = [[`${stem}.png`, png], [`${stem}.pgw`, text(worldFile())]];
  if (facts.crs?.wkt) files.push([`${stem}.prj`, text(facts.crs.wkt)]);
  saveFile(`${stem}.zip`, "application/zip", zip(files));
}

/** Runs something that takes a while from a button, and says if it fails. @param {string} id @param {() => Promise<void>} work */
function onClick(id, work) {
  const button = buttonById(id);
  button.addEventListener("click", async () => {
    button.setAttribute("aria-busy", "true");
    try {
      await work();
    } catch (error) {
      notify(wordsOf(error));
    }
    button.removeAttribute("aria-busy");
  });
}

function listenToSave() {
  buttonById("save").addEventListener("click", openSave);
  buttonById("copy-link").addEventListener("click", () => void copyAddress());
  buttonById("save-close").addEventListener("click", () => saveDialog.close());
  // A click beside the dialog is on its backdrop.
  saveDialog.addEventListener("click", (event) => {
    if (event.target === saveDialog) saveDialog.close();
  });
  onClick("copy-address", copyAddress);
  onClick("copy-command", () => copyText(commandWords().join(" ")));
  onClick("copy-digest", () => copyText(coverage.digest ?? ""));
  onClick("save-picture", savePicture);
  onClick("save-tiff", saveTiff);
  onClick("save-world", saveWorld);
}

// The robot, its frames and the data of its sensors, in 3D.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { texts } from "../../texts.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { SceneStage } from "./scene_stage.ts";

function ScenePanel({ context }: { context: PanelContext }) {
  const host = useRef<HTMLDivElement>(null);
  const stage = useSignal<SceneStage | undefined>(undefined);
  const failure = useSignal("");
  useEffect(() => {
    try {
      const made = new SceneStage(host.current as HTMLDivElement, context);
      stage.value = made;
      return () => made.dispose();
    } catch (error) {
      // Without WebGL there is no 3D; the other panels work.
      failure.value = texts.scene.noWebgl((error as Error).message);
      return undefined;
    }
  }, []);
  return (
    <div class={context.isCard ? "scene scene-card" : "scene"}>
      <div class="scene-picture" ref={host}>
        {failure.value && <p class="empty-line">{failure.value}</p>}
        {stage.value && stage.value.cellM.value > 0 && (
          <p class="scene-scale">{texts.scene.scale(stage.value.cellM.value)}</p>
        )}
      </div>
      {stage.value && (context.isCard ? <CardNotes stage={stage.value} /> : <SideBar stage={stage.value} />)}
    </div>
  );
}

function CardNotes({ stage }: { stage: SceneStage }) {
  const problem = stage.rows.value.find((row) => row.problem !== "")?.problem;
  return problem ? <p class="scene-note">{problem}</p> : null;
}

function SideBar({ stage }: { stage: SceneStage }) {
  const isOpen = useSignal(window.innerWidth >= 700);
  const note = useSignal("");
  const rows = stage.rows.value;
  const load = async (file: File | undefined) => {
    if (file === undefined) return;
    try {
      stage.applyRviz(await file.text());
      note.value = "";
    } catch (error) {
      note.value = (error as Error).message;
    }
  };
  return (
    <>
      <div class="scene-tools">
        <button type="button" class="button" onClick={() => stage.fit(true)}>
          {texts.scene.fit}
        </button>
        <button type="button" class="button" onClick={() => stage.view.lookFrom("top")}>
          {texts.scene.top}
        </button>
        <button type="button" class="button" onClick={() => stage.view.lookFrom("front")}>
          {texts.scene.front}
        </button>
        <button
          type="button"
          class="button"
          aria-expanded={isOpen.value}
          onClick={() => {
            isOpen.value = !isOpen.value;
          }}
        >
          {texts.scene.displays}
        </button>
      </div>
      {isOpen.value && (
        <aside class="scene-side">
          <label>
            {texts.scene.fixedFrame}
            <select
              value={stage.settings.fixedFrame ?? ""}
              onChange={(event) => stage.change({ fixedFrame: event.currentTarget.value })}
            >
              <option value="">{texts.scene.automatic(stage.fixedFrame.value)}</option>
              {stage.frames.value.map((frame) => (
                <option key={frame} value={frame}>
                  {frame}
                </option>
              ))}
            </select>
          </label>
          <label>
            {texts.scene.follow}
            <select
              value={stage.settings.followedFrame ?? ""}
              onChange={(event) => stage.change({ followedFrame: event.currentTarget.value })}
            >
              <option value="">{texts.scene.followNothing}</option>
              {stage.frames.value.map((frame) => (
                <option key={frame} value={frame}>
                  {frame}
                </option>
              ))}
            </select>
          </label>
          {rows.length === 0 && <p class="empty-line">{texts.scene.empty}</p>}
          <ul class="scene-list">
            {rows.map((row) => (
              <li key={row.key}>
                <label>
                  <input type="checkbox" checked={row.isShown} onChange={() => stage.toggle(row.key)} />
                  <span class="scene-title">{row.title}</span>
                  <span class="scene-type">{row.type}</span>
                </label>
                {row.problem && <p class="scene-problem">{row.problem}</p>}
              </li>
            ))}
          </ul>
          <label class="scene-file">
            {texts.scene.openRviz}
            <input type="file" accept=".rviz" onChange={(event) => load(event.currentTarget.files?.[0])} />
          </label>
          {note.value && <p class="scene-problem">{note.value}</p>}
        </aside>
      )}
    </>
  );
}

export default preactPanel(ScenePanel);

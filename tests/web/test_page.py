"""The dashboard's page in Chromium, with a real gateway and a simulated board."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

import rostether
from rostether.cli.dashboard.view import read_view
from web.browser import TIMEOUT_S, Browser
from web.robot import Robot

pytestmark = pytest.mark.asyncio(loop_scope="session")

RANGE = "rostether.feed('/ultrasound')"


async def test_the_overview_shows_the_board_and_moving_values(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url)
    await browser.wait_for(page, "document.querySelector('.card-boards .badge.ok') !== null")
    await browser.wait_for(page, "document.querySelector('.card-plots canvas') !== null")
    first = await browser.do("evaluate", page=page, script="document.querySelector('.cards').innerText")
    await browser.wait_for(page, f"document.querySelector('.cards').innerText !== {first!r}")
    await browser.wait_for(page, f"{RANGE}.rate.hertz(performance.now()) > 0")
    # Each card has enough rows, so that none covers another.
    rows = (
        "[...document.querySelectorAll('.card')].every((each) => /^span [1-9]/.test(each.style.gridRowEnd))"
    )
    await browser.wait_for(page, rows)
    # Each request is a round trip: the page, its style, its code, and the code of each kind of card.
    requests = "performance.getEntriesByType('resource').length"
    assert await browser.do("evaluate", page=page, script=requests) <= 8
    seen = await browser.do("seen", page=page)
    assert seen["hosts"] == [robot.url.split("/")[2]]
    assert seen["errors"] == []


async def test_the_3d_view_starts_after_the_first_values(robot: Robot, browser: Browser) -> None:
    # Without a graphics card, its start blocks the page for up to a second. Here the values are delayed.
    note = """
        const { set } = Object.getOwnPropertyDescriptor(WebSocket.prototype, "onmessage");
        Object.defineProperty(WebSocket.prototype, "onmessage", { set(handle) {
            set.call(this, (event) => {
                const late = () => { globalThis.valueMs ??= performance.now(); handle(event); };
                globalThis.openedMs ??= performance.now();
                if (typeof event.data === "string") handle(event);
                else setTimeout(late, 1000);
            });
        } });
    """
    page = await browser.do("open", url=robot.url, script=note)
    code = "performance.getEntriesByType('resource').find((each) => each.name.includes('scene_panel'))"
    await browser.wait_for(page, f"{code} !== undefined && globalThis.valueMs !== undefined")
    times = f"[{code}.startTime, valueMs, openedMs]"
    started_ms, value_ms, opened_ms = await browser.do("evaluate", page=page, script=times)
    # The longest wait for silent topics.
    assert started_ms > min(value_ms, opened_ms + 1500), (started_ms, value_ms, opened_ms)


async def test_the_list_of_topics_shows_the_newest_values(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/topics")
    row = "document.querySelector('tr[data-topic=\"/imu_data\"]')?.innerText"
    await browser.wait_for(page, f"{row}?.includes('Hz')")
    for _ in range(3):
        before = await browser.do("evaluate", page=page, script=row)
        await browser.wait_for(page, f"{row} !== {before!r}")


async def test_a_topic_is_shown_as_a_tree_with_its_values(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/topics")
    await browser.do("click", page=page, selector='tr[data-topic="/ultrasound"]')
    await browser.wait_for(
        page, "document.querySelector('.topics-detail .tree')?.innerText.includes('range:')"
    )
    detail = await browser.do("text", page=page, selector=".topics-detail")
    assert "sensor_msgs/Range" in detail
    assert "/virtual_board" in detail


async def test_a_hidden_page_has_no_subscriptions(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url)
    await browser.wait_for(page, "rostether.subscriptionCount > 2")
    await robot.wait_for_subscription("/ultrasound", expected=True)
    await browser.do("hide", page=page, hidden=True)
    await browser.wait_for(page, "rostether.subscriptionCount === 0")
    await robot.wait_for_subscription("/ultrasound", expected=False)
    await browser.do("hide", page=page, hidden=False)
    await robot.wait_for_subscription("/ultrasound", expected=True)
    await browser.wait_for(page, f"!{RANGE}.isStale()")


async def test_a_plot_continues_while_another_panel_is_shown(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url)
    script = "void (location.hash = '#/plots?s=' + btoa(JSON.stringify({ series: ['/ultrasound.range'] })))"
    await browser.do("evaluate", page=page, script=script)
    await browser.wait_for(page, f"document.querySelector('.plots-chart') && {RANGE}.last !== undefined")
    await browser.do("evaluate", page=page, script="void (location.hash = '#/console')")
    await browser.wait_for(page, "document.querySelector('.page-console') !== null")
    before = await browser.do("evaluate", page=page, script=f"{RANGE}.last.receivedMs")
    await browser.wait_for(page, f"{RANGE}.last.receivedMs > {before} + 1000")
    await browser.do("hide", page=page, hidden=True)
    await browser.wait_for(page, "rostether.subscriptionCount === 0")
    # Nothing is plotted any more.
    await browser.do("hide", page=page, hidden=False)
    await browser.do("evaluate", page=page, script=script)
    await browser.do("click", page=page, selector=".plots-legend [aria-label=Remove]")
    await browser.wait_for(page, "rostether.subscriptionCount === 0")


async def test_the_plot_without_a_choice_stays_when_its_board_is_unplugged(
    robot: Robot, browser: Browser
) -> None:
    page = await browser.do("open", url=f"{robot.url}#/plots")
    await browser.wait_for(page, "rostether.feed('/imu_data').last !== undefined")
    # The graph's next update restores the topic.
    script = """(async () => {
        rostether.topics.value = new Map([...rostether.topics.value].filter(([name]) => name !== "/imu_data"
        ));
        const shown = [];
        for (let count = 0; count < 20; count++) {
            await new Promise((go_on) => setTimeout(go_on, 10));
            shown.push(document.querySelector(".plots-legend").innerText);
        }
        return shown;
    })()"""
    shown = await browser.do("evaluate", page=page, script=script)
    assert all("/imu_data" in each for each in shown), shown


async def test_a_recording_has_the_format_that_suits_the_graph(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/recording")
    select = "document.querySelector('.recording select')"
    await browser.wait_for(page, f"{select}?.value === 'bag'")
    # As on a graph of only ROS 2.
    metadata = "{ ...rostether.info.value.metadata, recording_format: 'mcap' }"
    script = f"void (rostether.info.value = {{ ...rostether.info.value, metadata: {metadata} }})"
    await browser.do("evaluate", page=page, script=script)
    await browser.wait_for(page, f"{select}.value === 'mcap' && {select}.options[0].text.includes('ROS 2')")


async def test_the_picker_of_plots_searches_at_once(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/plots")
    await browser.do("click", page=page, selector=".plots-add")
    await browser.wait_for(page, "document.activeElement?.closest('.plots-picker') !== null")
    await browser.do("fill", page=page, selector=":focus", text="count")
    choices = "[...document.querySelectorAll('.plots-path')].map((each) => each.innerText)"
    await browser.wait_for(page, f"{choices}.join() === '/count.data'")

    async def press(key: str) -> None:
        event = f"new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }})"
        script = f"void document.activeElement.dispatchEvent({event})"
        await browser.do("evaluate", page=page, script=script)

    # A field in rqt_plot's notation. The list does not contain elements of arrays, but they can be typed.
    await browser.do("fill", page=page, selector=":focus", text="/imu_data/angular_velocity_covariance[4]")
    await browser.wait_for(page, f"{choices}.join() === '/imu_data.angular_velocity_covariance[4]'")
    await press("Enter")
    legend = "document.querySelector('.plots-legend')?.innerText ?? ''"
    await browser.wait_for(page, f"({legend}).includes('angular_velocity_covariance[4]')")
    await press("Escape")
    await browser.wait_for(page, "document.querySelector('.plots-picker') === null")


async def test_two_fingers_zoom_the_graph_on_a_phone(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/graph", width=390, touch=True)
    scroll = "document.querySelector('.graph-scroll')"
    await browser.wait_for(
        page, f"document.querySelector('.graph-node') && {scroll}.scrollWidth <= {scroll}.clientWidth"
    )
    touches = """void (() => {
        const target = document.querySelector('.graph-scroll');
        for (const [type, apart] of [['touchstart', 50], ['touchmove', 150]]) {
            const touches = [100 - apart / 2, 100 + apart / 2].map((clientX, identifier) =>
                new Touch({ identifier, target, clientX, clientY: 300 }));
            target.dispatchEvent(new TouchEvent(type, { touches, bubbles: true, cancelable: true }));
        }
    })()"""
    await browser.do("evaluate", page=page, script=touches)
    await browser.wait_for(page, f"{scroll}.scrollWidth > 1.5 * {scroll}.clientWidth")


async def test_a_graph_fits_into_the_width(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/graph", width=900)
    scroll = "document.querySelector('.graph-scroll')"
    await browser.wait_for(
        page, f"document.querySelector('.graph-node') && {scroll}.scrollWidth <= {scroll}.clientWidth"
    )
    await browser.do("click", page=page, selector="[aria-label=Larger]")
    await browser.wait_for(page, f"{scroll}.scrollWidth > {scroll}.clientWidth")
    # By keyboard.
    press = "new KeyboardEvent('keydown', { key: 'Enter', bubbles: true })"
    focus = "document.querySelector('.graph-node').focus()"
    script = f"void ({focus}, document.activeElement.dispatchEvent({press}))"
    await browser.do("evaluate", page=page, script=script)
    await browser.wait_for(page, "location.hash.startsWith('#/topics')")


async def test_the_map_keeps_moving_robots_in_view(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/map")
    async with rostether.join("gps", master=robot.master) as graph:
        robots = [await graph.publisher(f"/gps{number}/fix", "sensor_msgs/NavSatFix") for number in (1, 2)]
        inside = (
            "((map) => [...document.querySelectorAll('.leaflet-interactive')].filter((dot) => {"
            " const { left, right, top, bottom } = dot.getBoundingClientRect();"
            " return right > left && right - left === bottom - top && left >= map.left && right <= map.right"
            " && top >= map.top && bottom <= map.bottom; }).length)"
            "(document.querySelector('.map-picture')?.getBoundingClientRect())"
        )
        # The second robot crosses the date line.
        for longitude in (179.99, 179.995, -179.9):
            async with asyncio.timeout(TIMEOUT_S):
                while True:
                    robots[0].publish(latitude=-16.8, longitude=179.99)
                    robots[1].publish(latitude=-16.801, longitude=longitude)
                    await asyncio.sleep(0.1)
                    if await browser.do("evaluate", page=page, script=inside) == 2:
                        break
        # It is drawn 10 km away, not on the other side of the Earth.
        scale = "parseInt(document.querySelector('.leaflet-control-scale-line').innerText)"
        unit = "document.querySelector('.leaflet-control-scale-line').innerText.split(' ')[1]"
        assert await browser.do("evaluate", page=page, script=f"{unit} === 'm' || {scale} <= 10")


async def test_the_page_connects_again(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url)
    await browser.wait_for(page, f"{RANGE}.last !== undefined && !{RANGE}.isStale()")
    await robot.kill_dashboard()
    await browser.wait_for(page, "document.querySelector('.banner') !== null")
    # Old values must not look new.
    await browser.wait_for(page, "document.querySelector('.card-boards .badge.ok') === null")
    await robot.start_dashboard()
    await browser.wait_for(page, f"document.querySelector('.banner') === null && !{RANGE}.isStale()")
    await browser.wait_for(page, "document.querySelector('.card-boards .badge.ok') !== null")


async def test_every_panel_opens_without_an_error(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url)
    await browser.wait_for(page, "document.querySelectorAll('.card').length > 2")
    script = "[...document.querySelectorAll('.navigation a')].map((each) => each.getAttribute('href'))"
    links = await browser.do("evaluate", page=page, script=script)
    assert len(links) > 5
    for link in links:
        await browser.do("evaluate", page=page, script=f"location.hash = {link!r}")
        await browser.wait_for(
            page, f"document.querySelector('.page, .cards')?.childElementCount > 0 && {link!r}"
        )
    assert (await browser.do("seen", page=page))["errors"] == []


async def test_the_skip_link_stays_in_the_panel(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=f"{robot.url}#/topics")
    await browser.wait_for(page, "document.querySelector('tr[data-topic]') !== null")
    await browser.do("evaluate", page=page, script="document.querySelector('.skip').click()")
    await browser.wait_for(page, "document.activeElement.id === 'content'")
    await browser.wait_for(page, "location.hash === '#/topics'")


async def test_a_long_name_of_a_node_does_not_cover_its_log(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=f"{robot.url}#/console")
    node = "document.querySelector('.log-node')"
    await browser.wait_for(page, f"{node} !== null")
    name = "a_node_with_a_name_that_is_much_wider_than_its_column"
    # The new name may be replaced by the page's own text when a line arrives.
    await browser.wait_for(
        page, f"({node}.textContent = {name!r}) && {node}.scrollWidth <= {node}.clientWidth"
    )


async def test_a_long_diagnostic_fits_into_its_card(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=f"{robot.url}#/diagnostics")
    async with rostether.join("monitor", master=robot.master) as graph:
        publisher = await graph.publisher("/diagnostics", "diagnostic_msgs/DiagnosticArray", latch=True)
        publisher.publish(status=[{"name": "n" * 500, "message": "m" * 500}])
        await browser.wait_for(page, f"document.body.innerText.includes('{'n' * 500}')")
        content = "document.querySelector('.content')"
        await browser.wait_for(page, f"{content}.scrollWidth <= {content}.clientWidth")


async def test_a_phone_shows_everything_in_one_column(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url, width=360, height=740, touch=True)
    await browser.wait_for(page, "document.querySelectorAll('.card').length > 2")
    # The page is not wider than the screen.
    script = (
        "document.querySelector('.content').scrollWidth <= document.querySelector('.content').clientWidth"
    )
    await browser.wait_for(page, script)
    await browser.do("evaluate", page=page, script="void (location.hash = '#/boards')")
    name = "document.querySelector('.board-topics td a')"
    await browser.wait_for(page, f"{name} !== null")
    lengthen = f"void ({name}.textContent = 'a_topic_with_a_name_that_is_too_long_for_phones')"
    await browser.do("evaluate", page=page, script=lengthen)
    await browser.wait_for(page, script)
    await browser.do("click", page=page, selector=".navigation .more")
    await browser.do("click", page=page, selector='.navigation a[href="#/topics"]')
    await browser.wait_for(page, "document.querySelector('tr[data-topic]') !== null")


async def test_closed_panels_are_freed(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url)
    await browser.wait_for(page, "document.querySelectorAll('.card-plots canvas').length > 1")
    kept = []
    for _ in range(6):
        for link in ("#/topics", "#/plots", "#/boards", "#/"):
            await browser.do("evaluate", page=page, script=f"location.hash = {link!r}")
            await browser.wait_for(
                page, f"document.querySelector('.page, .cards')?.childElementCount > 0 && {link!r}"
            )
        await browser.wait_for(page, f"!{RANGE}.isStale()")
        # The panel that starts last; a round without it has fewer elements.
        await browser.wait_for(page, "document.querySelector('.card-scene canvas') !== null")
        kept.append(await browser.do("memory", page=page))
    # Values are kept for five minutes, so memory is not compared here; `make soak-page` does that.
    for what, noise in (("nodes", 250), ("listeners", 25)):
        first, last = ([each[what] for each in rounds] for rounds in (kept[:2], kept[-2:]))
        assert min(last) < min(first) + noise, kept


async def test_changes_of_the_overview_are_kept(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url)
    titles = "[...document.querySelectorAll('.card h2')].map((each) => each.innerText)"
    await browser.wait_for(page, f"{titles}.includes('/led') && {titles}.includes('/count')")
    await browser.do("click", page=page, selector=".arrange .button")
    for title in ("/led", "/count"):
        await browser.do("click", page=page, selector=f'.card[aria-label="{title}"] [aria-label="Remove"]')
    await browser.wait_for(page, f"!{titles}.includes('/led') && !{titles}.includes('/count')")
    series = ["/ultrasound.range", "/count.data"]
    script = f"location.hash = '#/plots?s=' + btoa(JSON.stringify({{ series: {series} }}))"
    await browser.do("evaluate", page=page, script=script)
    await browser.do("click", page=page, selector='[aria-label="Add to the overview"]')
    await browser.wait_for(page, f"{titles}.includes('/ultrasound, /count')")
    await browser.do("reload", page=page)
    await browser.wait_for(page, f"{titles}.includes('/ultrasound, /count') && !{titles}.includes('/led')")


async def test_a_token_is_read_from_the_address_and_hidden(robot: Robot, browser: Browser) -> None:
    await robot.kill_dashboard()
    await robot.start_dashboard("--token", "7f3c9a")
    refused = await browser.do("open", url=robot.url)
    await browser.wait_for(refused, "document.querySelector('.banner')?.innerText.includes('token')")
    page = await browser.do("open", url=robot.url + "#token=7f3c9a")
    await browser.wait_for(page, f"{RANGE}.last !== undefined")
    assert await browser.do("evaluate", page=page, script="location.href") == robot.url
    # The tab stores the token.
    await browser.do("reload", page=page)
    await browser.wait_for(page, f"{RANGE}.last !== undefined")


async def test_a_panel_that_could_not_be_loaded_is_loaded_again(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url)
    await browser.wait_for(page, f"{RANGE}.last !== undefined")
    await robot.kill_dashboard()
    # Its code is not loaded yet.
    await browser.do("evaluate", page=page, script="void (location.hash = '#/graph')")
    await browser.wait_for(page, "document.body.innerText.includes('could not be loaded')")
    await robot.start_dashboard()
    await browser.wait_for(page, "document.querySelector('.graph-drawing') !== null")


async def test_windows_of_rqt_and_rviz_are_panels(robot: Robot, browser: Browser, tmp_path: Path) -> None:
    rviz = tmp_path / "robot.rviz"
    rviz.write_text(
        "Visualization Manager:\n  Displays:\n    - Class: rviz/TF\n      Enabled: true\n"
        "  Global Options:\n    Fixed Frame: base_link\n"
    )
    await robot.kill_dashboard()
    await robot.start_dashboard("--panel", "scene", "--show", str(rviz))
    page = await browser.do("open", url=robot.url + "#" + read_view("scene", [str(rviz)]).fragment(""))
    await browser.wait_for(page, "document.querySelector('.scene-side select')?.value === 'base_link'")
    # Of its displays, only the frames are switched on.
    inputs = "[...document.querySelectorAll('.scene-side :checked')]"
    checked = f"{inputs}.map((each) => each.parentElement.innerText)"
    await browser.wait_for(page, f"{checked}.some((each) => each.endsWith('tf'))")
    await browser.wait_for(page, f"!{checked}.some((each) => each.includes('/ultrasound'))")
    plot = read_view("plots", ["/imu_data/angular_velocity/x:z", "/count/data"]).fragment("")
    await browser.do("evaluate", page=page, script=f"void (location.hash = {plot!r})")
    legend = "document.querySelector('.page-plots')?.innerText"
    for name in ("angular_velocity.x /imu_data", "angular_velocity.z /imu_data", "data /count"):
        await browser.wait_for(page, f"{legend}?.includes({name!r})")
    assert (await browser.do("seen", page=page))["errors"] == []

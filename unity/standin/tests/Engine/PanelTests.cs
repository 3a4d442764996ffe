// Events of UI Toolkit, as the stand-in sends them.
using System.Collections.Generic;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.UIElements;

namespace StandIn.Tests
{
    class PanelTests
    {
        readonly VisualElement root = new VisualElement();
        Panel panel;

        Button Add()
        {
            var button = new Button();
            button.style.height = 20;
            root.Add(button);
            return button;
        }

        [SetUp] void Begin() => panel = new Panel(root, 100, 100);

        [Test]
        void An_event_that_is_sent_meanwhile_waits()
        {
            var field = new Toggle();
            root.Add(field);
            var heard = new List<string>();
            field.RegisterValueChangedCallback(_ => heard.Add("changed"));
            field.value = true;
            Assert.That(heard, Is.EqualTo(new[] { "changed" }), "where nothing is on its way it is told at once");
            field.RegisterCallback<PointerDownEvent>(_ =>
            {
                field.value = false;
                heard.Add("set");
            });
            panel.PointerDown(field.worldBound.center);
            Assert.That(heard, Is.EqualTo(new[] { "changed", "set", "changed" }));
        }

        [Test]
        void A_click_begins_and_ends_on_the_same_element()
        {
            Button first = Add(), second = Add();
            panel.Update();
            int clicks = 0;
            first.clicked += () => clicks++;
            second.clicked += () => clicks++;
            panel.PointerDown(first.worldBound.center);
            panel.PointerUp(second.worldBound.center);
            Assert.That(clicks, Is.Zero);
            panel.Click(first.worldBound.center);
            Assert.That(clicks, Is.EqualTo(1));
        }

        [Test]
        void What_cannot_have_the_focus_takes_it_away()
        {
            Button first = Add(), second = Add();
            first.Focus();
            Assert.That(panel.focusController.focusedElement, Is.SameAs(first));
            second.SetEnabled(false);
            second.Focus();
            Assert.That(panel.focusController.focusedElement, Is.Null);
        }

        [Test]
        void A_menu_needs_a_target_in_a_panel()
        {
            Log.Expect(LogType.Error, "VisualElement Generic Menu needs a target");
            Log.Expect(LogType.Error, "Could not find rootVisualContainer");
            Open(null);
            Open(new VisualElement());
        }

        static void Open(VisualElement target) => new GenericDropdownMenu().DropDown(default, target);
    }
}

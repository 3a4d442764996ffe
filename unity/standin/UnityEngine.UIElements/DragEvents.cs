// What is dragged over elements in the editor, and dropped on them.
namespace UnityEngine.UIElements
{
    public abstract class MouseEventBase<T> : EventBase<T> where T : MouseEventBase<T>, new()
    {
        public Vector2 mousePosition { get; protected internal set; }
        public EventModifiers modifiers { get; protected internal set; }
        public bool shiftKey => (modifiers & EventModifiers.Shift) != 0;
        public bool ctrlKey => (modifiers & EventModifiers.Control) != 0;
        public Vector2 localMousePosition => mousePosition - (((currentTarget ?? target) as VisualElement)?.worldBound.position ?? default);
    }

    public abstract class DragAndDropEventBase<T> : MouseEventBase<T> where T : DragAndDropEventBase<T>, new() { }

    public class DragEnterEvent : DragAndDropEventBase<DragEnterEvent> { public DragEnterEvent() { bubbles = false; } }
    public class DragLeaveEvent : DragAndDropEventBase<DragLeaveEvent> { public DragLeaveEvent() { bubbles = false; } }
    public class DragUpdatedEvent : DragAndDropEventBase<DragUpdatedEvent> { }
    public class DragPerformEvent : DragAndDropEventBase<DragPerformEvent> { }
    public class DragExitedEvent : DragAndDropEventBase<DragExitedEvent> { }
}
